//! Every shader that is built in, for the test that compares Rust's tables with what the SPIR-V itself says.

use crate::embed;
use crate::gpu::ceilings::kernels;
use crate::gpu::{RasterShader, Shader};
use crate::metric;
use crate::scene;
use crate::synthesis::{prune, quilt_stages, repair, tile_mask, volume};
use crate::technique::{aligned, dependent, image, object};

/// The table of each compute shader, with the path of its source below glsl/. A test fails when one is missing.
pub fn shaders() -> Vec<(&'static str, Shader)> {
    vec![
        ("gpu/copy_words.comp", kernels::COPY_WORDS),
        ("gpu/copy_texels.comp", kernels::COPY_TEXELS),
        ("gpu/float_rate.comp", kernels::FLOAT_RATE),
        ("gpu/integer_rate.comp", kernels::INTEGER_RATE),
        ("gpu/dot8_rate.comp", kernels::DOT8_RATE),
        ("gpu/dot8_packed_rate.comp", kernels::DOT8_PACKED_RATE),
        ("gpu/search_path.comp", kernels::SEARCH_PATH),
        ("gpu/product_path.comp", kernels::PRODUCT_PATH),
        ("synthesis/quilt_guide.comp", quilt_stages::QUILT_GUIDE),
        ("synthesis/quilt_search.comp", quilt_stages::QUILT_SEARCH),
        ("synthesis/quilt_match.comp", quilt_stages::QUILT_MATCH),
        ("synthesis/quilt_aim.comp", prune::QUILT_AIM),
        ("synthesis/quilt_bound.comp", prune::QUILT_BOUND),
        ("synthesis/quilt_compare.comp", prune::QUILT_COMPARE),
        ("synthesis/quilt_place.comp", quilt_stages::QUILT_PLACE),
        ("synthesis/repair_fit.comp", repair::REPAIR_FIT),
        ("synthesis/tile_mask.comp", tile_mask::TILE_MASK),
        ("synthesis/volume_slice.comp", volume::VOLUME_SLICE),
        ("scene/motion.comp", scene::MOTION),
        ("scene/host_motion.comp", scene::HOST_MOTION),
        ("metric/feature_bins.comp", metric::FEATURE_BINS),
        ("metric/features.comp", metric::FEATURES),
        ("metric/feature_distance.comp", metric::FEATURE_DISTANCE),
        ("metric/feature_nearest.comp", metric::FEATURE_NEAREST),
        ("technique/image_guide.comp", image::IMAGE_GUIDE),
        ("technique/image_recombine.comp", image::IMAGE_RECOMBINE),
        ("technique/image_blend.comp", image::IMAGE_BLEND),
        ("technique/dependent_carry.comp", dependent::DEPENDENT_CARRY),
        ("technique/dependent_feather.comp", dependent::DEPENDENT_FEATHER),
    ]
}

/// The table of each pair of a vertex and a fragment shader, with the paths of their sources.
pub fn raster_shaders() -> Vec<(&'static str, &'static str, RasterShader)> {
    vec![
        ("scene/guide.vert", "scene/guide.frag", scene::GUIDE),
        ("technique/picture.vert", "embed/composite.frag", embed::COMPOSITE),
        ("technique/object.vert", "technique/object.frag", object::OBJECT),
        ("technique/picture.vert", "technique/image_carry.frag", image::IMAGE_CARRY),
        ("technique/picture.vert", "technique/image_settle.frag", image::IMAGE_SETTLE),
        ("technique/picture.vert", "technique/aligned.frag", aligned::ALIGNED),
        ("technique/faces.vert", "technique/faces.frag", dependent::FACES),
        ("technique/dependent_mesh.vert", "technique/dependent_mesh.frag", dependent::DEPENDENT_MESH),
        ("technique/picture.vert", "technique/dependent.frag", dependent::DEPENDENT),
    ]
}
