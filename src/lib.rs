//! impasto shades 3D models with real paint.
//!
//! An artist paints one strip, dark on the left to light on the right. The crate takes the strip and a 3D model and
//! makes the model look painted with it: colours from the strip, brush marks from the strip, shade for shade. It
//! follows R. Bailey, *Techniques for Non-photorealistic Shading Using Real Paint* (2004), on Vulkan 1.1.
//!
//! # The flow
//!
//! ```text
//! paint strip -> PaintSample -> Trajectory (colours by shade) -------------+
//!                          \--> TextureDifference (strip minus trajectory) |
//!                                          |                               |
//!                                          v                               v
//!                                  synthesis: quilt ----------------> technique -> frame
//!                                          ^                               ^
//!                                          |                               |
//! OBJ file -> Mesh -> GuidePass: shade, ID, depth -------------------------+
//!             Moment ----^
//! ```
//!
//! - [`paint`] takes a strip apart into colours by shade and texture, and puts the two together again; on the host.
//! - [`scene`] reads a model, places camera, lights and objects, and draws them into the guide: shade, ID and depth.
//! - [`synthesis`] makes more texture from a sample by quilting, and makes pictures tileable.
//! - [`technique`] paints, in four ways: it takes guides or a mesh, paints and synthesis, and gives a frame.
//! - [`metric`] says how good a picture is, and how calm a sequence (thesis chapter 9).
//! - [`embed`] is one mesh painted by one technique inside of an engine's frame.
//! - [`gpu`] holds every Vulkan call: a device of one's own or a host's, memory, passes and their barriers.
//! - [`error`] is the one error type; no input makes the crate panic.
//!
//! # Conventions
//!
//! - Colours and shades are 0 to 1, as they stand in the file; nothing is linearised. A shade is (1 + N.L) / 2.
//! - Lengths in pictures are pixels, rows from the top, and names end in `_px`. Object ID 0 is the background.
//! - What is called `new` prepares: it allocates and compiles. What is called `record` writes into a command buffer
//!   that it is given and never submits. [`gpu::Runner`] submits and waits, for those who have no renderer of their
//!   own.
//! - What was recorded is to be submitted in the order of recording, on one queue.
//! - The same sample, guide, parameters and seed give the same synthesis, byte for byte, on every device.
//!
//! # Example
//!
//! A picture without a renderer of one's own. The README shows this with long work split into parts, and how to record
//! into one's own command buffers.
//!
//! ```no_run
//! use impasto::gpu::{Context, ContextOptions, Runner, Uploads};
//! use impasto::paint::{PaintSample, TextureDifference, Trajectory, TrajectoryOptions};
//! use impasto::scene::{Camera, Framing, GuidePass, Lights, Mesh, MeshOptions, Moment};
//! use impasto::synthesis::quilt::QuiltStages;
//! use impasto::technique::image::{ImageParams, ImageTechnique};
//! use impasto::technique::Paint;
//!
//! # fn main() -> impasto::Result<()> {
//! let strip = PaintSample::load("strip.png")?;
//! let trajectory = Trajectory::extract(&strip, &TrajectoryOptions::default())?;
//! let texture = TextureDifference::extract(&strip, &trajectory);
//! let mesh = Mesh::load("model.obj", &MeshOptions::default())?.mesh;
//! let moment = Moment::at_rest(Camera::framing(&mesh, &Framing::default(), 1.0)?, Lights::default());
//!
//! let context = Context::new(&ContextOptions::default())?;
//! let mut uploads = Uploads::default();
//! let stages = QuiltStages::new(&context);
//! let guides = GuidePass::new(&context, &mut uploads, &mesh, (512, 512))?;
//! let paints = [Paint { texture: &texture, trajectory: &trajectory }];
//! let objects = vec![0; mesh.objects().len()];
//! let params = ImageParams::default();
//! let technique = ImageTechnique::new(&context, &mut uploads, &stages, &guides, &paints, &objects, &params)?;
//!
//! let mut runner = Runner::new(&context)?;
//! runner.run(|recorder| {
//!     uploads.record(recorder);
//!     guides.record(recorder, &moment)?;
//!     technique.record(recorder, params.quilt.seed, 0);
//!     Ok(())
//! })?;
//! let rgba: Vec<u8> = runner.read_image(technique.frame())?;
//! # Ok(())
//! # }
//! ```
#![warn(missing_docs)]

#[cfg(feature = "capi")]
pub mod capi;
pub mod embed;
pub mod error;
pub mod gpu;
pub mod metric;
pub mod paint;
mod random;
pub mod scene;
#[doc(hidden)]
pub mod shader_table;
pub mod synthesis;
pub mod technique;

pub use error::{Error, Result};

/// Compiles the README's examples.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

/// And those of the page on embedding.
#[cfg(doctest)]
#[doc = include_str!("../docs/embedding.md")]
struct Embedding;
