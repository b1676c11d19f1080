//! Which views show which faces (thesis chapter 8).
