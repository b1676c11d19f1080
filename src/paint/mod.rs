//! Paint: from a scanned strip to a colour trajectory and a brush texture (section 3.1.6 and chapter 4 of the thesis).

mod decode;
mod sample;

pub use sample::{PaintSample, StripHint, MAX_SIDE_PX};
