//! How good a picture is: the thesis's three metrics (chapter 9), and newer ones beside them.
//!
//! All of it looks at finished [`Picture`]s, ours or others', and is no part of a frame's work.
//!
//! ```text
//! frame -> Eligible -> choose -> BlockSearch::features --> BlockSearch::nearest (or a k-d tree) -> similarity, shading_error
//!                                          \---- two frames ----> coherence
//! ```
//!
//! [`series`] has the textures by which the thesis's measure itself is tested.
//!
//! | newer measure | compares | says |
//! |---|---|---|
//! | [`cooccurrence_error`] | sample and frame, as textures | which greys lie near each other (Bénard et al. 2009) |
//! | [`sliced_wasserstein`] | sample and frame, as textures | how far their patches are apart (Heitz et al. 2021) |
//! | `flip` (feature `cli`) | two frames, pixel by pixel | what a person sees change (Andersson et al. 2020) |
//! | [`frame_difference`] | two frames, surface point by surface point | how much the paint changes on the model |
//! | [`sharpness`], [`stroke_size`] | a frame with nothing | whether calm has cost the strokes their edges or size |

mod calm;
mod cooccurrence;
mod features;
#[cfg(feature = "cli")]
mod flip;
#[cfg(feature = "cli")]
mod kdtree;
mod motion;
mod picture;
mod sampling;
mod scores;
mod search;
pub mod series;
mod shades;
mod stroke;
mod wasserstein;

pub use calm::{frame_difference, FrameDifference};
pub use cooccurrence::{cooccurrence_error, CooccurrenceParams};
pub use features::{block_corner, check_block, FeatureBins, Features, BINS, BLOCK_PX, HISTOGRAMS};
#[cfg(feature = "cli")]
pub use flip::{flip, FlipErrors, FlipParams};
#[cfg(feature = "cli")]
pub use kdtree::KdTree;
pub use motion::Motion;
pub use picture::{Picture, MAX_PICTURE_SIDE_PX};
pub use sampling::{choose, Eligible};
pub use scores::{coherence, shading_error, similarity, Score};
pub use search::{BlockSearch, Neighbour, Source, NEAREST};
pub(crate) use search::{FEATURES, FEATURE_BINS, FEATURE_DISTANCE, FEATURE_NEAREST};
pub use shades::Shades;
pub use stroke::{sharpness, stroke_size};
pub use wasserstein::{sliced_wasserstein, WassersteinParams};
