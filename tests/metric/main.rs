//! Metrics: the thesis's (chapter 9), on the GPU against plain code and known answers, and newer ones.

mod calm;
#[path = "../common/mod.rs"]
mod common;
#[cfg(feature = "cli")]
mod flip;
#[cfg(feature = "cli")]
mod kdtree;
mod modern;
mod motion;
mod search;

use common::{noise, Validated};
use impasto::metric::Picture;
use impasto::paint::PaintSample;

fn strip(name: &str) -> Picture {
    let bytes = std::fs::read(std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets").join(name));
    let sample = PaintSample::decode(&bytes.expect("an asset"), name.as_ref()).expect("a strip");
    Picture::new(sample.width(), sample.height(), sample.to_rgba8()).expect("a picture")
}

fn noise_picture(width: u32, height: u32, seed: u32) -> Picture {
    Picture::new(width, height, noise(width, height, seed)).expect("a picture")
}

fn part(picture: &Picture, (left, top): (u32, u32), (width, height): (u32, u32)) -> Picture {
    let at = |x: u32, y: u32| picture.pixels()[((top + y) * picture.width() + left + x) as usize];
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| at(x, y));
    Picture::new(width, height, pixels.collect()).expect("a part")
}
