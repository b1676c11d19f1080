//! Every compute shader that is built in, for the test that compares Rust's tables with what the SPIR-V itself says.

use crate::gpu::Shader;
use crate::synthesis::{quilt, tile_mask};
use crate::technique::image;

/// The table of each compute shader, with the path of its source below glsl/. A test fails when one is missing.
pub fn shaders() -> Vec<(&'static str, Shader)> {
    vec![
        ("synthesis/quilt_guide.comp", quilt::QUILT_GUIDE),
        ("synthesis/quilt_search.comp", quilt::QUILT_SEARCH),
        ("synthesis/quilt_place.comp", quilt::QUILT_PLACE),
        ("synthesis/tile_mask.comp", tile_mask::TILE_MASK),
        ("technique/image_histogram.comp", image::IMAGE_HISTOGRAM),
        ("technique/image_levels.comp", image::IMAGE_LEVELS),
        ("technique/image_guide.comp", image::IMAGE_GUIDE),
        ("technique/image_recombine.comp", image::IMAGE_RECOMBINE),
    ]
}
