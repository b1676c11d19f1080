//! Every compute shader that is built in, for the test that compares Rust's tables with what the SPIR-V itself says.

use crate::gpu::Shader;
use crate::synthesis::quilt;

/// The table of each shader in glsl/, with the path of its source below it. A test fails when one is missing.
pub fn shaders() -> Vec<(&'static str, Shader)> {
    vec![
        ("synthesis/quilt_guide.comp", quilt::QUILT_GUIDE),
        ("synthesis/quilt_search.comp", quilt::QUILT_SEARCH),
        ("synthesis/quilt_place.comp", quilt::QUILT_PLACE),
    ]
}
