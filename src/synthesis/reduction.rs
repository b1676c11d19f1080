//! Strips of a sample as fewer numbers, and looked up at any position: what [`super::strips`] finds directions in, and
//! projects fast.

use super::principal::{sum_of_products, symmetric_axes, Matrix, LANES};
use super::sample::summed_area;
use super::strips::StripShape;
use crate::random;
use std::f64::consts::FRAC_1_SQRT_2;

/// Strips that principal components are found from.
const STRIPS: usize = 512;
/// Share of the variance of colour that the kept axes hold.
const COLOUR_SHARE: f64 = 0.995;
/// Pixels that the colours are measured at, about.
const COLOURS: usize = 1 << 16;
/// Products that [`StripBasis::coordinates`] adds up before it adds the sum to others. A product then passes through
/// fewer roundings than the margin allows for, whatever the shape: with T taps and A axes of colour, sqrt(A) (32 + T /
/// 32 + 11) of the host are less than 2 (3 width + height + 32).
const PRODUCTS: usize = 32;

/// An orthonormal map from strips to fewer numbers, which makes the rest several times faster: colours become one to
/// three numbers along the sample's main axes of colour, and pixels are added in pairs of neighbours.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Reduction {
    shape: StripShape,
    pub(super) centre: [i32; 3],
    pub(super) axes: Vec<[f64; 3]>,
    /// From a pixel to its neighbour.
    step: (usize, usize),
}

/// One number of a reduced strip: one pixel or two, along one axis of colour.
pub(super) struct Tap {
    pub(super) axis: usize,
    x: usize,
    y: usize,
    /// With its neighbour.
    pub(super) paired: bool,
}

impl Reduction {
    /// For strips of a sample `width` pixels wide.
    pub(super) fn new(texels: &[[u8; 4]], width: u32, shape: StripShape) -> Self {
        let (centre, axes) = main_colours(texels);
        // Neighbours that are alike lose least when they are added.
        let differences = |distance: usize| {
            let pairs = texels.iter().zip(&texels[distance..]).step_by(some_of(texels));
            pairs.map(|(a, b)| (0..3).map(|c| u64::from(a[c].abs_diff(b[c])).pow(2)).sum::<u64>()).sum::<u64>()
        };
        let across = shape.height == 1 || shape.width > 1 && differences(1) < differences(width as usize);
        Reduction { shape, centre, axes, step: if across { (1, 0) } else { (0, 1) } }
    }

    /// All numbers of a reduced strip.
    pub(super) fn taps(&self) -> Vec<Tap> {
        let (width, height) = (self.shape.width as usize, self.shape.height as usize);
        let (step_x, step_y) = self.step;
        let mut taps = Vec::new();
        for axis in 0..self.axes.len() {
            for y in (0..height).step_by(1 + step_y) {
                for x in (0..width).step_by(1 + step_x) {
                    taps.push(Tap { axis, x, y, paired: x + step_x < width && y + step_y < height });
                }
            }
        }
        taps
    }

    pub(super) fn pixels(&self, tap: &Tap) -> impl Iterator<Item = (usize, usize)> {
        let ((x, y), step) = ((tap.x, tap.y), self.step);
        (0..1 + usize::from(tap.paired)).map(move |i| (x + i * step.0, y + i * step.1))
    }
}

/// A picture, ready to look up the reduced strips at any position.
pub(super) struct Picture {
    width: usize,
    /// For each axis the paired pixels, then for each axis the pixels alone, as large as the picture each; and a few
    /// zeros, because positions are read eight at a time.
    planes: Vec<f32>,
    /// Where each tap of the strip at position 0 is.
    offsets: Vec<usize>,
    /// The summed-area table of the squared distances from the centre.
    squares: Vec<u32>,
}

impl Picture {
    pub(super) fn new(reduction: &Reduction, texels: &[[u8; 4]], size: (u32, u32)) -> Self {
        let width = size.0 as usize;
        let (step_x, step_y) = reduction.step;
        let step = step_x + step_y * width;
        let centred = |t: &[u8; 4]| [0, 1, 2].map(|c| i32::from(t[c]) - reduction.centre[c]);
        let (mut pairs, mut singles) = (Vec::new(), Vec::new());
        for axis in &reduction.axes {
            let axis = axis.map(|a| a as f32);
            let along = |t: &[u8; 4]| centred(t).iter().zip(axis).map(|(&c, a)| c as f32 * a).sum::<f32>();
            let single: Vec<f32> = texels.iter().map(along).collect();
            let next = single.iter().skip(step).chain(std::iter::repeat(&0.0));
            pairs.extend(single.iter().zip(next).map(|(a, b)| (a + b) * FRAC_1_SQRT_2 as f32));
            singles.extend(single);
        }
        let mut planes = pairs;
        planes.extend(singles);
        planes.extend([0.0; LANES]);
        let plane = |tap: &Tap| tap.axis + if tap.paired { 0 } else { reduction.axes.len() };
        let offset = |tap: &Tap| plane(tap) * texels.len() + tap.y * width + tap.x;
        let offsets = reduction.taps().iter().map(offset).collect();
        let square = |t: &[u8; 4]| centred(t).iter().map(|c| c.unsigned_abs().pow(2)).sum();
        Picture { width, planes, offsets, squares: summed_area(texels.iter().map(square), width) }
    }

    /// Four components of the strip at a position and of the next ones to its right.
    pub(super) fn project(&self, weights: &[[f32; 4]], (x, y): (usize, usize)) -> [[f32; LANES]; 4] {
        let planes = &self.planes[y * self.width + x..];
        let mut total = [[0.0; LANES]; 4];
        for (weights, offsets) in weights.chunks(PRODUCTS).zip(self.offsets.chunks(PRODUCTS)) {
            let eights = offsets.iter().filter_map(|&offset| planes.get(offset..)?.first_chunk());
            let sums = sum_of_products(weights.iter().zip(eights));
            total.iter_mut().flatten().zip(sums.iter().flatten()).for_each(|(total, sum)| *total += sum);
        }
        total
    }

    /// The squared length of the strip at a position.
    pub(super) fn square(&self, shape: StripShape, (x, y): (usize, usize)) -> u32 {
        let at = |x: usize, y: usize| self.squares[y * (self.width + 1) + x];
        let (right, below) = (x + shape.width as usize, y + shape.height as usize);
        at(right, below).wrapping_sub(at(right, y)).wrapping_sub(at(x, below)).wrapping_add(at(x, y))
    }
}

/// Strips of a sample, reduced, one in a row, from places all over it.
///
/// And the sum of their squared lengths, before they were reduced.
pub(super) fn some_strips(reduction: &Reduction, taps: &[Tap], texels: &[[u8; 4]], size: (u32, u32)) -> (Matrix, f64) {
    let picture = Picture::new(reduction, texels, size);
    let columns = (size.0 - reduction.shape.width + 1) as usize;
    let positions = columns * (size.1 - reduction.shape.height + 1) as usize;
    let place = |n: usize| {
        let share = (n as f64 + random::unit(0, n as u32, 0)) / STRIPS as f64;
        let position = (share * positions as f64) as usize;
        position / columns * picture.width + position % columns
    };
    let places: Vec<usize> = (0..STRIPS).map(place).collect();
    let square =
        |&place: &usize| f64::from(picture.square(reduction.shape, (place % picture.width, place / picture.width)));
    let squares = places.iter().map(square).sum();
    let strips = Matrix::new(STRIPS, taps.len().next_multiple_of(4), |strip, tap| {
        picture.offsets.get(tap).map_or(0.0, |offset| picture.planes[offset + places[strip]])
    });
    (strips, squares)
}

/// A step from texel to texel that visits some of all. It is odd so that it does not stay in one column.
fn some_of(texels: &[[u8; 4]]) -> usize {
    (texels.len() / COLOURS) | 1
}

/// The mean colour, rounded, and as many main axes of colour as matter.
fn main_colours(texels: &[[u8; 4]]) -> ([i32; 3], Vec<[f64; 3]>) {
    let some = || texels.iter().step_by(some_of(texels));
    let number = some().count().max(1) as f64;
    let sum = |c: usize| some().map(|t| u64::from(t[c])).sum::<u64>() as f64;
    let centre = [0, 1, 2].map(|c| (sum(c) / number).round() as i32);
    let mut moments = [[0.0; 3]; 3];
    for texel in some() {
        let colour = [0, 1, 2].map(|c| f64::from(i32::from(texel[c]) - centre[c]));
        for (row, a) in moments.iter_mut().zip(colour) {
            row.iter_mut().zip(colour).for_each(|(moment, b)| *moment += a * b);
        }
    }
    let axes = symmetric_axes(moments);
    let total: f64 = axes.iter().map(|(variance, _)| variance).sum();
    let mut held = 0.0;
    let mut kept = Vec::new();
    for (variance, axis) in axes {
        if kept.is_empty() || held < COLOUR_SHARE * total {
            kept.push(axis);
        }
        held += variance;
    }
    (centre, kept)
}
