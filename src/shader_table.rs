//! Every shader that is built in, for the test that compares Rust's tables with what the SPIR-V itself says.

use crate::gpu::{RasterShader, Shader};
use crate::scene;
use crate::synthesis::{quilt, tile_mask, volume};
use crate::technique::{aligned, dependent, image, object};

/// The table of each compute shader, with the path of its source below glsl/. A test fails when one is missing.
pub fn shaders() -> Vec<(&'static str, Shader)> {
    vec![
        ("synthesis/quilt_guide.comp", quilt::QUILT_GUIDE),
        ("synthesis/quilt_search.comp", quilt::QUILT_SEARCH),
        ("synthesis/quilt_place.comp", quilt::QUILT_PLACE),
        ("synthesis/tile_mask.comp", tile_mask::TILE_MASK),
        ("synthesis/volume_slice.comp", volume::VOLUME_SLICE),
        ("technique/image_histogram.comp", image::IMAGE_HISTOGRAM),
        ("technique/image_levels.comp", image::IMAGE_LEVELS),
        ("technique/image_guide.comp", image::IMAGE_GUIDE),
        ("technique/image_recombine.comp", image::IMAGE_RECOMBINE),
        ("technique/dependent_blend.comp", dependent::DEPENDENT_BLEND),
    ]
}

/// The table of each pair of a vertex and a fragment shader, with the path of their sources without the extension.
pub fn raster_shaders() -> Vec<(&'static str, RasterShader)> {
    vec![
        ("scene/guide", scene::GUIDE),
        ("technique/object", object::OBJECT),
        ("technique/aligned", aligned::ALIGNED),
        ("technique/faces", dependent::FACES),
        ("technique/dependent", dependent::DEPENDENT),
    ]
}
