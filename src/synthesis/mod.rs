//! Texture synthesis: more paint like the sample's, in any size (thesis 3.2.2, 3.2.3 and chapter 6).
//!
//! Where it stands in the flow: paint goes in as a sample (the scanned strip itself, or its texture difference), and a
//! texture of any size comes out, on which the techniques draw. *Quilting* copies small square blocks of the sample
//! side by side and joins neighbours along a minimum error cut; an optional guide picture steers each block to the part
//! of the sample that has the right shade. *Tiling by mask* then makes a picture repeat without a visible edge.
//!
//! Every stage exists twice: on the GPU, and as a plain CPU oracle in the module whose name ends in `_oracle`. The two
//! share [`params`] and nothing else, and must give the same bytes: all arithmetic is on integers, random choices come
//! from a hash of (seed, block, frame), and ties go to the lowest index.

pub mod calibrate;
pub mod params;
mod principal;
pub(crate) mod prune;
pub mod quilt;
pub mod quilt_oracle;
#[doc(hidden)]
pub mod quilt_stages;
mod reduction;
pub mod repair;
pub mod repair_oracle;
pub(crate) mod sample;
mod search_path;
pub(crate) mod strips;
pub mod tile_mask;
pub mod tile_oracle;
pub(crate) mod volume;
