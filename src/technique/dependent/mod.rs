//! View-dependent interpolation (thesis chapter 8).

mod blend;
mod coverage;
