//! Paint: from a scanned strip to a colour trajectory and a brush texture (section 3.1.6 and chapter 4 of the thesis).
//!
//! The first room of the flow; it knows nothing of meshes, synthesis or GPUs. All of it runs on the host: small data.
//!
//! ```text
//! picture file -> PaintSample -> column means -> sorted path -> timing -> speed curve -> Trajectory
//!                      |                                                                     |
//!                      +------------------------- minus -------------------------------------+-> TextureDifference
//!
//! TextureDifference + any Trajectory -> PaintSample
//! ```
//!
//! ```
//! use impasto::paint::{ColorStop, PaintSample, TextureDifference, Trajectory, TrajectoryOptions};
//!
//! # fn main() -> impasto::Result<()> {
//! // A tiny strip: two rows, dark to light, with a bit of texture. A real one comes from `PaintSample::load`.
//! let gray = |value: f32| [value; 3];
//! let rows = [0.1, 0.4, 0.7, 0.9, 0.1, 0.6, 0.7, 0.9];
//! let strip = PaintSample::from_pixels(4, 2, rows.map(gray).to_vec())?;
//!
//! let trajectory = Trajectory::extract(&strip, &TrajectoryOptions::default())?;
//! let texture = TextureDifference::extract(&strip, &trajectory);
//!
//! // The same strokes in other colours.
//! let stops = ColorStop::parse_list("0:#102030,0.5:#ff8800,1:#ffffff")?;
//! let recolored = texture.recombine(&Trajectory::from_stops(&stops, 4)?);
//! assert_eq!((recolored.width(), recolored.height()), (4, 2));
//! # Ok(())
//! # }
//! ```

mod decode;
mod grid;
mod path;
mod rgb;
mod sample;
mod separation;
mod smooth;
mod speed;
mod stops;
mod timing;
mod trajectory;
mod wrap;

pub(crate) use decode::{decode_picture, read_picture};
pub use sample::{PaintSample, StripHint, MAX_SIDE_PX};
pub use separation::TextureDifference;
pub use speed::SpeedCurve;
pub use stops::ColorStop;
pub use trajectory::{Residual, Timing, Trajectory, TrajectoryOptions};
