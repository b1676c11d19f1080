//! The thesis's techniques: what each prepares once, and what it records for a frame.
//!
//! A technique takes guides from the scene, samples from paint and textures from synthesis, and draws a frame. It
//! records into a command buffer that it is given and never submits.

pub mod image;
