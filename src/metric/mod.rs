//! How good a picture is: the thesis's three metrics (chapter 9), and newer ones beside them.
//!
//! All of it looks at finished [`Picture`]s, ours or others', and is no part of a frame's work.

mod features;
mod picture;
mod sampling;
mod search;

pub use features::{block_corner, check_block, FeatureBins, Features, BINS, BLOCK_PX, HISTOGRAMS};
pub use picture::{Picture, MAX_PICTURE_SIDE_PX};
pub use sampling::{choose, Eligible};
pub use search::{BlockSearch, Neighbour, Source, NEAREST};
pub(crate) use search::{FEATURES, FEATURE_BINS, FEATURE_DISTANCE, FEATURE_NEAREST};
