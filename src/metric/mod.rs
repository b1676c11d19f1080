//! How good a picture is: the thesis's three metrics (chapter 9), and newer ones beside them.

mod picture;

pub use picture::{Picture, MAX_PICTURE_SIDE_PX};
