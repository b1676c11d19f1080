//! Object-based texture mapping (thesis chapter 5).

mod coordinates;
