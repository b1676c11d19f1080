//! A map of measured errors as a picture: a colour for each place, and a bar below that says what the colours mean.
//!
//! Colours are those of viridis, in which equal steps of the error look equal, which keeps its order in grey print and
//! for people who see fewer colours. Places that were not measured are grey, which viridis does not contain.

use super::failure::{Failure, Result};
use super::plot::short;
use colorous::VIRIDIS;
use font8x8::legacy::BASIC_LEGACY;
use image::{Rgba, RgbaImage};

/// The longer side of a map is enlarged to about this, by a whole factor, so that its cells can be seen.
const SHOWN_PX: u32 = 640;
/// The legend is laid out on squares of whole pixels, [`Legend::unit`]; so many, side by side, have room for numbers
/// and words.
const LEGEND: u32 = 320;
/// Parts of the legend, in its units: to the sides of the bar, where the outer numbers reach; the bar; the lines below
/// it; a character; between two rows.
const MARGIN: u32 = 32;
const BAR: u32 = 14;
const TICK: u32 = 4;
const CHARACTER: u32 = 8;
const GAP: u32 = 6;
/// A number and some space to the next.
const NUMBER: u32 = 8 * CHARACTER;
/// Significant digits of a number.
const DIGITS: usize = 3;

const WHITE: Rgba<u8> = Rgba([255; 4]);
const INK: Rgba<u8> = Rgba([34, 34, 34, 255]);
const NOT_MEASURED: Rgba<u8> = Rgba([160, 160, 160, 255]);

/// Errors, none of them below 0, over a grid of places.
#[derive(Debug, Clone)]
pub struct ErrorMap {
    width: u32,
    height: u32,
    values: Vec<Option<f32>>,
    top: f32,
}

impl ErrorMap {
    /// A map of `width` x `height` places, rows from the top. What is `None` or not a number was not measured.
    ///
    /// Colours run from 0 to the greatest error. Other maps may look alike with [`with_top`](Self::with_top).
    pub fn new(width: u32, height: u32, values: Vec<Option<f32>>) -> Result<Self> {
        if width == 0 || height == 0 || values.len() as u64 != u64::from(width) * u64::from(height) {
            return Err(Failure::new(format!(
                "a map of {width} x {height} errors cannot hold {} of them",
                values.len()
            )));
        }
        let values: Vec<_> = values.into_iter().map(|value| value.filter(|value| !value.is_nan())).collect();
        let top = values.iter().flatten().copied().filter(|value| value.is_finite()).fold(0.0, f32::max);
        Ok(ErrorMap { width, height, values, top: usable_top(top) })
    }

    /// The error at which the scale of colours ends: by itself the greatest one.
    pub fn top(&self) -> f32 {
        self.top
    }

    /// The same errors on a scale that ends at `top`, so that several maps can be compared. Greater errors have the
    /// last colour.
    pub fn with_top(mut self, top: f32) -> Self {
        self.top = usable_top(top);
        self
    }

    /// The colour of an error.
    fn color(&self, value: Option<f32>) -> Rgba<u8> {
        match value {
            Some(value) => viridis(value / self.top),
            None => NOT_MEASURED,
        }
    }

    /// The map with its legend, opaque.
    pub fn picture(&self) -> RgbaImage {
        let cell = (SHOWN_PX / self.width.max(self.height)).max(1);
        let (width, height) = (self.width * cell, self.height * cell);
        let unit = (width / LEGEND).max(2);
        let legend = Legend { unit, width: width.max(LEGEND * unit) };
        let mut picture = RgbaImage::from_pixel(legend.width, height + legend.height(self), WHITE);
        for (index, value) in (0..).zip(&self.values) {
            let (x, y) = (index % self.width * cell, index / self.width * cell);
            fill(&mut picture, (x, y), (cell, cell), self.color(*value));
        }
        legend.draw(&mut picture, height, self);
        picture
    }
}

/// Where the legend's parts are.
struct Legend {
    /// Pixels of the picture to a unit of the legend.
    unit: u32,
    /// Pixels from side to side.
    width: u32,
}

impl Legend {
    fn height(&self, map: &ErrorMap) -> u32 {
        let scale = GAP + BAR + TICK + 2 + CHARACTER + GAP;
        let words = if map.values.contains(&None) { CHARACTER + GAP } else { 0 };
        (scale + words) * self.unit
    }

    fn draw(&self, picture: &mut RgbaImage, below: u32, map: &ErrorMap) {
        let unit = self.unit;
        let (left, top) = (MARGIN * unit, below + GAP * unit);
        let length = self.width - 2 * left;
        // A frame of one unit around the bar, which its own colours lie on.
        fill(picture, (left - unit, top), (length + 2 * unit, BAR * unit), INK);
        for x in 0..length {
            let color = viridis(x as f32 / (length - 1) as f32);
            fill(picture, (left + x, top + unit), (1, (BAR - 2) * unit), color);
        }
        for tick in ticks(map.top, length / (NUMBER * unit)) {
            let x = left + (f64::from(length - 1) * tick / f64::from(map.top)).round() as u32;
            fill(picture, (x - unit / 2, top + BAR * unit), (unit, TICK * unit), INK);
            let text = short(tick, DIGITS);
            let half = text.len() as u32 * CHARACTER * unit / 2;
            self.write(picture, (x.saturating_sub(half), top + (BAR + TICK + 2) * unit), &text);
        }
        if map.values.contains(&None) {
            let y = top + (BAR + TICK + 2 + CHARACTER + GAP) * unit;
            fill(picture, (left - unit, y), (CHARACTER * unit, CHARACTER * unit), NOT_MEASURED);
            self.write(picture, (left + (CHARACTER + GAP) * unit, y), "not measured");
        }
    }

    fn write(&self, picture: &mut RgbaImage, (left, top): (u32, u32), text: &str) {
        for (index, character) in (0..).zip(text.chars()) {
            let rows = BASIC_LEGACY.get(character as usize).copied().unwrap_or_default();
            for (row, bits) in (0..).zip(rows) {
                for column in (0..CHARACTER).filter(|column| bits >> column & 1 == 1) {
                    let place = (left + (index * CHARACTER + column) * self.unit, top + row * self.unit);
                    fill(picture, place, (self.unit, self.unit), INK);
                }
            }
        }
    }
}

/// The end of a scale that can be divided by: where all errors are 0, or unknown, any will do.
fn usable_top(top: f32) -> f32 {
    if top.is_normal() && top > 0.0 {
        top
    } else {
        1.0
    }
}

/// The colour at a place between 0 and 1; the nearest of these beyond.
fn viridis(place: f32) -> Rgba<u8> {
    let color = VIRIDIS.eval_continuous(f64::from(place.clamp(0.0, 1.0)));
    Rgba([color.r, color.g, color.b, 255])
}

/// 0, round numbers, and `top`, with `intervals` intervals at most between them.
fn ticks(top: f32, intervals: u32) -> Vec<f64> {
    let top = f64::from(top);
    let least = top / f64::from(intervals.max(1));
    let power = 10f64.powi(least.log10().floor() as i32);
    let steps = [1.0, 2.0, 5.0, 10.0].map(|digit| digit * power);
    // The tolerance takes up what rounding leaves between numbers that are meant to be equal.
    let step = steps.into_iter().find(|step| *step >= least * (1.0 - 1e-6)).unwrap_or(top);
    let round = (0..intervals).map(|index| f64::from(index) * step);
    round.take_while(|tick| *tick <= top - least * (1.0 - 1e-6)).chain([top]).collect()
}

/// Fills a rectangle, as far as it lies in the picture.
fn fill(picture: &mut RgbaImage, (left, top): (u32, u32), (width, height): (u32, u32), color: Rgba<u8>) {
    for y in top..(top + height).min(picture.height()) {
        for x in left..(left + width).min(picture.width()) {
            picture.put_pixel(x, y, color);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(width: u32, height: u32, values: &[Option<f32>]) -> ErrorMap {
        ErrorMap::new(width, height, values.to_vec()).expect("a map")
    }

    #[test]
    fn every_place_has_the_color_of_its_error_in_the_middle_of_its_cell() {
        // The ends and the middle of viridis.
        let (first, middle, last) = (Rgba([68, 1, 84, 255]), Rgba([33, 145, 140, 255]), Rgba([253, 231, 37, 255]));
        let errors = [Some(0.0), Some(2.0), Some(4.0), None, Some(f32::INFINITY), Some(f32::NAN)];
        let picture = map(3, 2, &errors).picture();
        let cell = SHOWN_PX / 3;
        let expected = [first, middle, last, NOT_MEASURED, last, NOT_MEASURED];
        for (index, color) in (0..).zip(expected) {
            let (x, y) = (index % 3 * cell + cell / 2, index / 3 * cell + cell / 2);
            let found = picture.get_pixel(x, y);
            let near = found.0.iter().zip(color.0).all(|(a, b)| a.abs_diff(b) <= 1);
            assert!(near, "place {index}: {found:?}, not {color:?}");
        }
        assert!(picture.height() > 2 * cell && picture.width() >= 3 * cell);
    }

    #[test]
    fn maps_on_one_scale_have_one_color_for_one_error() {
        let a = map(2, 1, &[Some(1.0), Some(0.5)]);
        let b = map(1, 1, &[Some(0.5)]).with_top(a.top());
        assert_eq!(a.color(Some(0.5)), b.color(Some(0.5)));
        assert_eq!(map(1, 1, &[Some(0.0)]).top(), 1.0, "where nothing is wrong any scale will do");
    }

    #[test]
    fn the_legend_shows_its_numbers_and_grows_with_the_map() {
        let pixels_of_ink = |map: ErrorMap| map.picture().pixels().filter(|pixel| **pixel == INK).count();
        let small = pixels_of_ink(map(1, 1, &[Some(1.0)]));
        assert!(pixels_of_ink(map(1, 1, &[Some(0.123)])) > small, "more digits, more ink");
        let large = map(2560, 1, &[Some(1.0); 2560]);
        assert!(pixels_of_ink(large) > 4 * small);
        // As tall and narrow as a map can be, the legend has its room.
        assert_eq!(map(1, 700, &[Some(1.0); 700]).picture().width(), LEGEND * 2);
    }

    #[test]
    fn ticks_are_round_numbers_and_the_end() {
        assert_eq!(ticks(8.0, 4), [0.0, 2.0, 4.0, 6.0, 8.0]);
        assert_eq!(ticks(1.0, 4), [0.0, 0.5, 1.0]);
        assert_eq!(ticks(8.25, 4), [0.0, 5.0, 8.25]);
        assert_eq!(ticks(6.5, 4), [0.0, 2.0, 4.0, 6.5], "6 would stand in the way of 6.5");
        for top in [f32::MIN_POSITIVE, 1e-7, 3e33, f32::MAX] {
            let ticks = ticks(top, 4);
            assert!((3..=5).contains(&ticks.len()) && ticks.is_sorted(), "{top}: {ticks:?}");
        }
    }

    #[test]
    fn another_number_of_errors_than_of_places_is_refused() {
        assert!(ErrorMap::new(2, 2, vec![None; 3]).is_err());
        assert!(ErrorMap::new(0, 0, Vec::new()).is_err());
    }
}
