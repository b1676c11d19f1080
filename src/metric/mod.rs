//! How good a picture is: the thesis's three metrics (chapter 9), and newer ones beside them.
//!
//! | newer measure | compares | says |
//! |---|---|---|
//! | [`cooccurrence_error`] | sample and frame, as textures | which greys lie near each other (Bénard et al. 2009) |
//! | [`sliced_wasserstein`] | sample and frame, as textures | how far their patches are apart (Heitz et al. 2021) |
//! | `flip` (feature `cli`) | two frames, pixel by pixel | what a person sees change (Andersson et al. 2020) |

mod cooccurrence;
#[cfg(feature = "cli")]
mod flip;
mod picture;
mod wasserstein;

pub use cooccurrence::{cooccurrence_error, CooccurrenceParams};
#[cfg(feature = "cli")]
pub use flip::{flip, FlipErrors, FlipParams};
pub use picture::{Picture, MAX_PICTURE_SIDE_PX};
pub use wasserstein::{sliced_wasserstein, WassersteinParams};
