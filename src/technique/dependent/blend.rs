//! How much of which slice a face takes, seen from a direction (thesis chapter 8).
