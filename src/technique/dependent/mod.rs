//! View-dependent interpolation (thesis chapter 8).

mod blend;
mod coverage;

pub use blend::{blend_weights, MAX_BLENDED};
pub use coverage::{default_views, Coverage, CoverageReport, Covered, Round, Slice, View, MAX_SLICES, MAX_VIEWS};
