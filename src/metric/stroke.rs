//! How sharp the marks of a texture are, and how large.
//!
//! A way of painting can be made calm by blurring its strokes or by letting them grow, and then it is calm for the
//! wrong reason. Both are seen in one frame, without its sample: sharpness in the steps of grey from pixel to pixel,
//! size in how far grey goes on alike. They mean something beside the same figure of another frame; best of the texture
//! alone (`Show::Texture`), where shading makes no steps.
//!
//! Grey is 0.299 R + 0.587 G + 0.114 B of the stored values. `objects` has a number for every pixel, row by row from
//! the top, 0 in the background: outlines between objects are no strokes.

use super::picture::{grey, Picture};
use crate::{Error, Result};

/// The mean length of the gradient of grey (0 to 1), per pixel: central differences, of all pixels whose 3 x 3
/// neighbours are inside and belong to the same object. 0 is flat, 0.5 the most along a row or column.
///
/// # Errors
/// [`Error::Parameter`] for another number of objects than of pixels, and where no pixel has such neighbours.
pub fn sharpness(picture: &Picture, objects: &[u32]) -> Result<f64> {
    let greys = Greys::new(picture, objects)?;
    let (mut sum, mut count) = (0.0, 0u32);
    for y in 1..greys.height.saturating_sub(1) {
        for x in 1..greys.width.saturating_sub(1) {
            if greys.is_surrounded(x, y) {
                let across = greys.value(x + 1, y) - greys.value(x - 1, y);
                let down = greys.value(x, y + 1) - greys.value(x, y - 1);
                sum += across.hypot(down) / 2.0;
                count += 1;
            }
        }
    }
    if count == 0 {
        return Err(Error::parameter("number of pixels whose 3 x 3 neighbours are of one object", 0, "at least 1"));
    }
    Ok(sum / f64::from(count))
}

/// The size of strokes in pixels: the lag at which the autocorrelation of grey has fallen to one half.
///
/// Autocorrelation at a lag is the mean product of (grey - mean grey) over pairs of pixels of one object that far
/// apart, over the variance; along rows and along columns, and the mean of both. Between whole lags it is taken as
/// linear. `None` for a flat picture, and where it has not fallen to one half before there are no pairs left along rows
/// or columns.
///
/// # Errors
/// [`Error::Parameter`] for another number of objects than of pixels, and where no pixel is inside.
pub fn stroke_size(picture: &Picture, objects: &[u32]) -> Result<Option<f64>> {
    let greys = Greys::new(picture, objects)?.centered()?;
    if greys.is_flat() {
        return Ok(None);
    }
    let variance = greys.product((0, 0)).unwrap_or_default();
    let mut before = 1.0;
    for lag in 1..greys.width.min(greys.height) {
        let (Some(across), Some(down)) = (greys.product((lag, 0)), greys.product((0, lag))) else { break };
        let here = (across + down) / 2.0 / variance;
        if here <= 0.5 {
            return Ok(Some((lag - 1) as f64 + (before - 0.5) / (before - here)));
        }
        before = here;
    }
    Ok(None)
}

/// A picture in grey, and what each pixel belongs to.
struct Greys {
    width: usize,
    height: usize,
    values: Vec<f64>,
    /// 0 for what is not inside.
    objects: Vec<u32>,
}

impl Greys {
    fn new(picture: &Picture, objects: &[u32]) -> Result<Self> {
        let (width, height) = (picture.width() as usize, picture.height() as usize);
        if objects.len() != width * height {
            return Err(Error::parameter("number of pixels' objects", objects.len(), format!("{width} x {height}")));
        }
        let values = picture.pixels().iter().map(|pixel| f64::from(grey(*pixel)) / 255e3).collect();
        let inside = |(pixel, object): (&[u8; 4], &u32)| if pixel[3] == 255 { *object } else { 0 };
        Ok(Greys { width, height, values, objects: picture.pixels().iter().zip(objects).map(inside).collect() })
    }

    fn value(&self, x: usize, y: usize) -> f64 {
        self.values[y * self.width + x]
    }

    /// Whether a pixel that is not at the picture's edge has neighbours of its own object only.
    fn is_surrounded(&self, x: usize, y: usize) -> bool {
        let object = self.objects[y * self.width + x];
        let row = |y: usize| &self.objects[y * self.width + x - 1..=y * self.width + x + 1];
        object != 0 && (y - 1..=y + 1).all(|y| row(y).iter().all(|other| *other == object))
    }

    /// The values of all that is inside.
    fn inside(&self) -> impl Iterator<Item = f64> + '_ {
        self.values.iter().zip(&self.objects).filter(|(_, object)| **object != 0).map(|(value, _)| *value)
    }

    fn is_flat(&self) -> bool {
        let mut inside = self.inside();
        let first = inside.next();
        inside.all(|value| Some(value) == first)
    }

    /// With the mean of all that is inside taken off.
    fn centered(mut self) -> Result<Self> {
        let (sum, count) = self.inside().fold((0.0, 0u32), |(sum, count), value| (sum + value, count + 1));
        if count == 0 {
            return Err(Error::parameter("number of pixels inside the picture", 0, "at least 1"));
        }
        let mean = sum / f64::from(count);
        self.values.iter_mut().for_each(|value| *value -= mean);
        Ok(self)
    }

    /// The mean product of pixels of one object that are so far apart; `None` where there are none.
    fn product(&self, (dx, dy): (usize, usize)) -> Option<f64> {
        let (mut sum, mut count) = (0.0, 0u32);
        for y in 0..self.height - dy {
            for first in y * self.width..(y + 1) * self.width - dx {
                let second = first + dy * self.width + dx;
                if self.objects[first] != 0 && self.objects[first] == self.objects[second] {
                    sum += self.values[first] * self.values[second];
                    count += 1;
                }
            }
        }
        (count > 0).then(|| sum / f64::from(count))
    }
}
