//! Lower bounds of the overlap error, so that a search can leave out positions that cannot be chosen.
//!
//! A block is compared with the sample along strips: rectangles of `d = 3 * width * height` numbers. Each strip of the
//! sample gets a few coordinates here, once, on the host; they go to the device as layers of an image. The search
//! gives what is painted on its canvas coordinates of the same kind, and one dot product of `K + 2` numbers then says
//! how large the error is at least. Positions whose bound is above the largest error that may be chosen are left out.
//! The others are compared in integers as ever, so that the result is the same to the byte.
//!
//! **The bound.** Let x and y be two strips with [`StripBasis::centre`] subtracted, Q a matrix of K orthonormal rows,
//! and n = |x|^2. With c = Q x and r = sqrt(n - |c|^2), the length of what Q leaves out, Cauchy and Schwarz say
//! `x.y <= c_x.c_y + r_x r_y`. So `|x - y|^2 = n_x + n_y - 2 x.y` is at least
//! `n_x + n_y - 2 (c_x.c_y + r_x r_y)`, whatever rows Q has; principal components keep r small and the bound tight.
//!
//! **Rounding.** Let u = 2^-24. A sum of products in f32 is off by at most u (twice that on a device, which may round
//! towards zero) times the number of roundings that a product passes through, times the sum of their absolute values; K
//! such sums together by sqrt(K) times that. Who sums row by row, and then the rows, takes a product through no more
//! than 3 width + height roundings. All who compute coordinates keep to that, or are better. With the rounding of the
//! weights, of the detour in [`StripBasis::coordinates`] and of the square root, a computed c is off by at most e |x|,
//! `e = 2 u sqrt(K) (3 width + height + 32)`. The centre is integral, which makes x exact. Therefore, with a margin m,
//! - `r = sqrt(n (1 + m) - |c|^2)` is never too short if `m >= 2 e + e^2` plus the rounding of n, which a device may
//!   sum in f32 too, and of the difference. Without this, an error e of c could shorten r by sqrt(2 e) |x|, far more
//!   than any margin on n makes up for.
//! - `x.y` then exceeds the computed `c_x.c_y + r_x r_y` by at most `(2 e + e^2) |x| |y|`, and as
//!   `2 |x| |y| <= n_x + n_y`, taking `(1 - m) n` for n makes up for it. The same margin holds the rounding of the
//!   final sum of at most 4 (K + 3) terms (four strips), whose absolute values add up to at most twice the sum of n.
//!
//! Together `m = u (4 sqrt(K) (3 width + height + 32) + 2 (3 width + height) + 16 (K + 8))`, and one hundredth more for
//! terms of second order: 2^-12.7 for a strip of 5 x 32 px and K = 30. Paints that hardly differ from their mean
//! but smoothly need it as small as that.

use super::principal::{principal_directions, LANES};
use super::reduction::{some_strips, Picture, Reduction};
use std::f64::consts::FRAC_1_SQRT_2;
use std::thread;

/// Half of the distance from 1 to the next f32.
const ROUNDOFF: f64 = 1.0 / (1 << 24) as f64;
/// Most threads that work on coordinates.
const MOST_THREADS: usize = 8;

/// A rectangle of pixels along which a block is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct StripShape {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
}

impl StripShape {
    /// How many numbers a strip has.
    fn dimension(self) -> usize {
        3 * self.width as usize * self.height as usize
    }
}

/// Orthonormal directions in the space of a sample's strips of one shape.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct StripBasis {
    /// What a strip is.
    pub shape: StripShape,
    /// How many directions, K.
    pub components: usize,
    /// The colour that is subtracted: the sample's mean, rounded.
    pub centre: [f32; 3],
    /// The directions: `[component][pixel, row by row][rgb]`. Directions that a small or flat sample does not have are
    /// zeros.
    pub weights: Vec<f32>,
    /// What makes bounds safe against rounding (see the module).
    pub margin: f32,
    /// Of the squared lengths of the strips that the directions were found from, the share that the first, the first
    /// two ... of them hold.
    held: Vec<f64>,
    reduction: Reduction,
    /// The directions in the reduced space: for each layer, for each tap, a weight for each of four components.
    layers: Vec<Vec<[f32; 4]>>,
}

impl StripBasis {
    /// Finds the main directions of a sample's own strips.
    ///
    /// `texels` are RGBA, row by row, `size` = (width, height) of them; the shape fits in. `components` is K; K + 3 is
    /// a multiple of 8.
    ///
    /// Any orthonormal directions give safe bounds, so they are found fast rather than well: from some hundred strips,
    /// in the reduced space, by a few rounds of subspace iteration.
    pub fn new(texels: &[[u8; 4]], size: (u32, u32), shape: StripShape, components: usize) -> Self {
        let reduction = Reduction::new(texels, size.0, shape);
        let taps = reduction.taps();
        let (strips, square) = some_strips(&reduction, &taps, texels, size);
        let (found, held) = principal_directions(&strips, components);
        let held = held.into_iter().map(|held| if square > 0.0 { held / square } else { 1.0 }).collect();
        let weight = |component: usize, tap: usize| found.get(component).map_or(0.0, |direction| direction[tap]);
        let four = |layer: usize, tap: usize| [0, 1, 2, 3].map(|k| weight(4 * layer + k, tap) as f32);
        let layers = (0..components.div_ceil(4)).map(|l| (0..taps.len()).map(|t| four(l, t)).collect()).collect();

        let dimension = shape.dimension();
        let mut weights = vec![0.0; components * dimension];
        for (component, weights) in weights.chunks_exact_mut(dimension).enumerate() {
            for (index, tap) in taps.iter().enumerate() {
                let scale = weight(component, index) * if tap.paired { FRAC_1_SQRT_2 } else { 1.0 };
                for (x, y) in reduction.pixels(tap) {
                    let pixel = 3 * (y * shape.width as usize + x);
                    for (weight, axis) in weights[pixel..].iter_mut().zip(reduction.axes[tap.axis]) {
                        *weight += (scale * axis) as f32;
                    }
                }
            }
        }
        let centre = reduction.centre.map(|c| c as f32);
        StripBasis { shape, components, centre, weights, margin: margin(shape, components), held, reduction, layers }
    }

    /// How much of the squared lengths of strips is left out by the first `components` directions, as a share.
    pub fn left_out(&self, components: usize) -> f64 {
        1.0 - components
            .checked_sub(1)
            .and_then(|last| self.held.get(last).or(self.held.last()))
            .map_or(0.0, |held| *held)
    }

    /// Keeps the first `components` directions.
    pub fn truncate(&mut self, components: usize) {
        if components < self.components {
            self.components = components;
            self.weights.truncate(components * self.shape.dimension());
            self.margin = margin(self.shape, components);
            self.layers.truncate(components.div_ceil(4));
            let kept = components % 4;
            if let Some(last) = self.layers.last_mut() {
                last.iter_mut().for_each(|four| four[kept..].fill(0.0));
            }
        }
    }

    /// Coordinates of the strips whose top left pixels are `first` + (i, j), i < `count.0`, j < `count.1`.
    ///
    /// Layer by layer, each of `count.0 * count.1` texels row by row, a texel four coordinates, (K + 3) / 4 layers. A
    /// strip x has the coordinates `c_0 ... c_(K-1)`, 0, `r = sqrt(max(n (1 + margin) - |c|^2, 0))` and `n (1 -
    /// margin)`. Against `-2 c ... , 0, -2 r, 1` of a strip y, with `n_y (1 - margin)` added, they bound |x - y|^2 from
    /// below.
    ///
    /// The strips lie inside of the picture `texels`, RGBA, row by row, `size` = (width, height) of them.
    pub fn coordinates(
        &self,
        texels: &[[u8; 4]],
        size: (u32, u32),
        first: (u32, u32),
        count: (u32, u32),
    ) -> Vec<[f32; 4]> {
        let (width, rows) = (count.0 as usize, count.1 as usize);
        let mut coordinates = vec![[0.0; 4]; self.layers.len() * width * rows];
        if coordinates.is_empty() {
            return coordinates;
        }
        let threads = thread::available_parallelism().map_or(1, usize::from).clamp(1, MOST_THREADS);
        let band_rows = rows.div_ceil(threads);
        let mut bands: Vec<Vec<&mut [[f32; 4]]>> = (0..rows.div_ceil(band_rows)).map(|_| Vec::new()).collect();
        for layer in coordinates.chunks_exact_mut(width * rows) {
            bands.iter_mut().zip(layer.chunks_mut(width * band_rows)).for_each(|(band, part)| band.push(part));
        }
        let picture = &Picture::new(&self.reduction, texels, size);
        thread::scope(|scope| {
            for (index, mut band) in bands.into_iter().enumerate() {
                let top = first.1 as usize + index * band_rows;
                scope.spawn(move || self.fill(picture, (first.0 as usize, top), width, &mut band));
            }
        });
        coordinates
    }

    /// As [`StripBasis::coordinates`], in fewer bytes.
    pub fn packed(&self, texels: &[[u8; 4]], size: (u32, u32), first: (u32, u32), count: (u32, u32)) -> Packed {
        Packed::new(&self.coordinates(texels, size, first, count), count.0 as usize * count.1 as usize)
    }

    /// Writes the coordinates of the strips from `first` on, `width` in a row, to each layer's part.
    fn fill(&self, picture: &Picture, first: (usize, usize), width: usize, parts: &mut [&mut [[f32; 4]]]) {
        let rows = parts.first().map_or(0, |part| part.len() / width);
        for row in 0..rows {
            for column in (0..width).step_by(LANES) {
                let at = (first.0 + column, first.1 + row);
                let texels = row * width + column..row * width + width.min(column + LANES);
                let mut squares = [0.0; LANES];
                for (weights, part) in self.layers.iter().zip(parts.iter_mut()) {
                    let sums = picture.project(weights, at);
                    for (lane, texel) in part[texels.clone()].iter_mut().enumerate() {
                        *texel = [0, 1, 2, 3].map(|k| sums[k][lane]);
                        squares[lane] += texel.iter().map(|c| f64::from(c * c)).sum::<f64>();
                    }
                }
                let Some(last) = parts.last_mut() else { continue };
                for (lane, texel) in last[texels].iter_mut().enumerate() {
                    let n = picture.square(self.shape, (at.0 + lane, at.1));
                    [texel[2], texel[3]] = ends(n, squares[lane], self.margin);
                }
            }
        }
    }
}

/// Coordinates as whole numbers of a step: eight to a texel, two to a word, the first of them in the low half.
pub(crate) struct Packed {
    /// Layer by layer. The last words of a position are `c_(K-1)` and r, and n as the bits of an f32.
    pub texels: Vec<[u32; 4]>,
    /// What a coordinate of 1 stands for.
    pub step: f32,
}

impl Packed {
    /// Packs pairs of layers of [`StripBasis::coordinates`]. c is rounded to the nearest, which takes at most
    /// `sqrt(K) step |y|` from a bound. r is rounded up, which is safe.
    fn new(coordinates: &[[f32; 4]], positions: usize) -> Self {
        let (others, last) = coordinates.split_at(coordinates.len() - positions);
        let largest = |most: f32, c: &f32| most.max(c.abs());
        let most = others.as_flattened().iter().fold(1.0, largest);
        let most = last.iter().flat_map(|texel| &texel[..3]).fold(most, largest);
        let step = most / f32::from(i16::MAX - 1);
        let per_step = 1.0 / step;
        let whole = |c: f32| u32::from((c * per_step).round_ties_even() as i16 as u16);
        let pair = |low: f32, high: f32| whole(low) | whole(high) << 16;
        let mut texels = Vec::with_capacity(coordinates.len() / 2);
        for layers in coordinates.chunks_exact(2 * positions.max(1)) {
            let (first, second) = layers.split_at(positions);
            let four =
                |a: &[f32; 4], b: &[f32; 4]| [pair(a[0], a[1]), pair(a[2], a[3]), pair(b[0], b[1]), pair(b[2], b[3])];
            texels.extend(first.iter().zip(second).map(|(a, b)| four(a, b)));
        }
        let begin = texels.len().saturating_sub(positions);
        for (texel, [c, _, r, n]) in texels[begin..].iter_mut().zip(last) {
            let r = ((r * per_step).ceil() as i16).max(0) as u16;
            texel[2..].copy_from_slice(&[whole(*c) | u32::from(r) << 16, n.to_bits()]);
        }
        Packed { texels, step }
    }
}

/// The last two coordinates of a strip of squared length `n`, and `squares` that of its other coordinates.
fn ends(n: u32, squares: f64, margin: f32) -> [f32; 2] {
    let (n, margin) = (f64::from(n), f64::from(margin));
    [(n * (1.0 + margin) - squares).max(0.0).sqrt() as f32, (n * (1.0 - margin)) as f32]
}

/// Share of n by which bounds are lowered for the rounding of all that is computed in f32 (see the module).
fn margin(shape: StripShape, components: usize) -> f32 {
    let (passed, k) = (f64::from(3 * shape.width + shape.height), components as f64);
    (1.01 * ROUNDOFF * (4.0 * k.sqrt() * (passed + 32.0) + 2.0 * passed + 16.0 * (k + 8.0))) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;

    const SIZE: (u32, u32) = (57, 45);
    const SHAPES: [StripShape; 6] = [
        StripShape { width: 5, height: 32 },
        StripShape { width: 27, height: 5 },
        StripShape { width: 4, height: 1 },
        StripShape { width: 1, height: 4 },
        StripShape { width: 1, height: 1 },
        StripShape { width: 7, height: 8 },
    ];

    fn picture(colour: impl Fn(u32, u32) -> [u32; 3]) -> Vec<[u8; 4]> {
        let pixels = (0..SIZE.0 * SIZE.1).map(|i| colour(i % SIZE.0, i / SIZE.0).map(|c| c.min(255) as u8));
        pixels.map(|[r, g, b]| [r, g, b, 255]).collect()
    }

    /// Noise of one colour on stripes of another, both slanted.
    fn textured() -> Vec<[u8; 4]> {
        picture(|x, y| {
            let (stroke, grain) = ((x + 2 * y) / 7 % 5, random::bits(4, (x + y / 2) / 3 + 99 * y, 0) % 64);
            [40 + 30 * stroke + grain, 80 + 20 * stroke, 30 + grain / 2]
        })
    }

    fn pictures() -> [(&'static str, Vec<[u8; 4]>); 6] {
        let bits = |x: u32, y: u32| random::bits(7, x, y);
        [
            ("noise", picture(|x, y| [bits(x, y) & 255, bits(x, y) >> 8 & 255, bits(x, y) >> 24])),
            ("black and white", picture(|x, y| [255 * (bits(x, y) & 1); 3])),
            ("black or white", picture(|x, _| [255 * (x / 30); 3])),
            ("flat", picture(|_, _| [200, 30, 7])),
            ("gradient", picture(|x, y| [4 * x, 2 * x + y, 255 - 4 * x])),
            ("textured", textured()),
        ]
    }

    fn strip(texels: &[[u8; 4]], shape: StripShape, (x, y): (u32, u32)) -> Vec<[u8; 3]> {
        let at = |x, y| texels[(y * SIZE.0 + x) as usize];
        let rows = (y..y + shape.height).flat_map(|y| (x..x + shape.width).map(move |x| (x, y)));
        rows.map(|(x, y)| at(x, y)).map(|[r, g, b, _]| [r, g, b]).collect()
    }

    fn error(a: &[[u8; 3]], b: &[[u8; 3]]) -> u32 {
        a.as_flattened().iter().zip(b.as_flattened()).map(|(&a, &b)| u32::from(a.abs_diff(b)).pow(2)).sum()
    }

    /// All positions at which a strip of this shape lies inside of a picture.
    fn count(shape: StripShape) -> (u32, u32) {
        (SIZE.0 - shape.width + 1, SIZE.1 - shape.height + 1)
    }

    /// What a device computes of what is painted on its canvas: the other side of the dot product, and the constant.
    fn template(basis: &StripBasis, strip: &[[u8; 3]]) -> (Vec<f32>, f32) {
        let row = 3 * basis.shape.width as usize;
        let x: Vec<f32> =
            strip.iter().flat_map(|pixel| [0, 1, 2].map(|c| f32::from(pixel[c]) - basis.centre[c])).collect();
        let dot = |a: &[f32], b: &[f32]| -> f32 {
            a.chunks(row).zip(b.chunks(row)).map(|(a, b)| a.iter().zip(b).map(|(a, b)| a * b).sum::<f32>()).sum()
        };
        let mut c: Vec<f32> = basis.weights.chunks(x.len()).map(|weights| dot(weights, &x)).collect();
        let n = dot(&x, &x);
        let squares: f32 = c.iter().map(|c| c * c).sum();
        // A place is left empty, so that there are K + 3.
        c.extend([0.0, (n * (1.0 + basis.margin) - squares).max(0.0).sqrt()]);
        (c.iter().map(|c| -2.0 * c).chain([1.0]).collect(), n * (1.0 - basis.margin))
    }

    /// The coordinates of one position, out of all layers.
    fn at(coordinates: &[[f32; 4]], positions: usize, position: usize) -> impl Iterator<Item = f32> + '_ {
        coordinates.iter().skip(position).step_by(positions).flatten().copied()
    }

    /// The bound of the error of a strip at a position of a sample.
    fn bounds<'a>(basis: &StripBasis, coordinates: &'a [[f32; 4]], strip: &[[u8; 3]]) -> impl Fn(usize) -> f32 + 'a {
        let (factors, constant) = template(basis, strip);
        let positions = coordinates.len() / factors.len().div_ceil(4);
        move |p| at(coordinates, positions, p).zip(&factors).fold(constant, |sum, (c, f)| sum + c * f)
    }

    /// The same from packed coordinates, as `quilt_bound` adds it up after `quilt_aim`.
    fn packed_bounds<'a>(basis: &StripBasis, packed: &'a Packed, strip: &[[u8; 3]]) -> impl Fn(usize) -> f32 + 'a {
        let (mut factors, constant) = template(basis, strip);
        let [others @ .., _] = &mut factors[..] else { panic!("no factors") };
        others.iter_mut().for_each(|factor| *factor *= packed.step);
        // What is left out and n come one place earlier, beside an empty one.
        factors[basis.components..].rotate_left(1);
        let n = constant / (1.0 - basis.margin);
        let rounded = 1.01 * (basis.components as f32).sqrt() * packed.step;
        let constant = constant - rounded * (n * (1.0 + basis.margin)).sqrt();
        let layers = factors.len() / 8;
        let positions = packed.texels.len() / layers;
        move |p| {
            let words: Vec<u32> = packed.texels.iter().skip(p).step_by(positions).flatten().copied().collect();
            let [words @ .., n] = &words[..] else { panic!("no words") };
            let halves = words.iter().flat_map(|word| [*word as u16 as i16, (word >> 16) as i16]).map(f32::from);
            halves.chain([f32::from_bits(*n)]).zip(&factors).fold(constant, |sum, (c, f)| sum + c * f)
        }
    }

    fn some_positions(shape: StripShape) -> impl Iterator<Item = (u32, u32)> {
        let count = count(shape);
        (0..5).map(move |n| (random::bits(n, 0, 1) % count.0, random::bits(n, 0, 2) % count.1))
    }

    /// Bounds and errors of strips of some pictures at many positions of one; of its own strips, also where they are.
    fn compare(sample: &[[u8; 4]], shape: StripShape, components: usize, mut each: impl FnMut(&str, f32, u32)) {
        let basis = StripBasis::new(sample, SIZE, shape, components);
        let count = count(shape);
        let coordinates = basis.coordinates(sample, SIZE, (0, 0), count);
        let packed = basis.packed(sample, SIZE, (0, 0), count);
        for (name, other) in [("itself", sample.to_vec())].into_iter().chain(pictures()) {
            for position in some_positions(shape).take(if name == "itself" { 5 } else { 1 }) {
                let wanted = strip(&other, shape, position);
                let bounds = bounds(&basis, &coordinates, &wanted);
                let packed_bounds = packed_bounds(&basis, &packed, &wanted);
                let own = (position.1 * count.0 + position.0) as usize;
                for p in (0..(count.0 * count.1) as usize).step_by(7).chain([own]) {
                    let there = strip(sample, shape, (p as u32 % count.0, p as u32 / count.0));
                    each(name, bounds(p), error(&there, &wanted));
                    each(&format!("{name}, packed"), packed_bounds(p), error(&there, &wanted));
                }
            }
        }
    }

    #[test]
    fn a_bound_is_never_above_the_error() {
        for (name, sample) in pictures() {
            for shape in SHAPES {
                // Every number of components for the two shapes of a block, and one that is more than there can be.
                let all = match shape.width {
                    5 => &[5, 21, 45][..],
                    27 => &[13, 29],
                    _ => &[13],
                };
                for &components in all {
                    compare(&sample, shape, components, |other, bound, error| {
                        let exact = f64::from(bound) <= f64::from(error);
                        assert!(exact, "{name} {shape:?} K = {components}, strip of {other}: {bound} > {error}");
                    });
                }
            }
        }
    }

    #[test]
    fn the_bound_of_four_strips_is_never_above_their_error() {
        for (name, sample) in pictures() {
            let sides = [SHAPES[0], SHAPES[1], SHAPES[0], SHAPES[1]];
            let bases = sides.map(|shape| StripBasis::new(&sample, SIZE, shape, 45));
            // The same strip as in the sample, so that the error is as small as can be beside the terms.
            let (mut bound, mut constants) = (0.0f32, 0.0f32);
            for (basis, position) in bases.iter().zip([(0, 0), (5, 0), (25, 3), (9, 40)]) {
                let coordinates = basis.coordinates(&sample, SIZE, position, (1, 1));
                let (factors, constant) = template(basis, &strip(&sample, basis.shape, position));
                bound = at(&coordinates, 1, 0).zip(factors).fold(bound, |sum, (c, f)| sum + c * f);
                constants += constant;
            }
            assert!(bound + constants <= 0.0, "{name}: {bound} {constants}");
        }
    }

    #[test]
    fn few_positions_have_a_bound_near_the_least_error() {
        let sample = textured();
        for (shape, most) in [(SHAPES[0], 0.07), (SHAPES[1], 0.07)] {
            let basis = StripBasis::new(&sample, SIZE, shape, 29);
            let (mut near, mut all) = (0, 0);
            let count = count(shape);
            // Where the strip itself lies is taken out.
            let coordinates = basis.coordinates(&sample, SIZE, (0, 0), count);
            for position in some_positions(shape) {
                let wanted = strip(&sample, shape, position);
                let far = |p: u32| (p % count.0).abs_diff(position.0) > 3 || (p / count.0).abs_diff(position.1) > 3;
                let bounds = bounds(&basis, &coordinates, &wanted);
                let found: Vec<(f32, u32)> = (0..count.0 * count.1)
                    .filter(|&p| far(p))
                    .map(|p| (bounds(p as usize), error(&strip(&sample, shape, (p % count.0, p / count.0)), &wanted)))
                    .collect();
                let least = found.iter().map(|(_, error)| *error).min().expect("positions");
                near += found.iter().filter(|(bound, _)| f64::from(*bound) <= 1.1 * f64::from(least)).count();
                all += found.len();
            }
            let share = near as f64 / all as f64;

            assert!(share < most, "{shape:?}: {share}");
        }
    }

    #[test]
    fn what_the_basis_holds_is_bounded_to_within_the_margin() {
        // One axis of colour, and steps of two columns: nothing is lost by adding pixels in pairs.
        let sample = picture(|x, _| [10 + 4 * (x / 2); 3]);
        let shape = StripShape { width: 6, height: 2 };
        let basis = StripBasis::new(&sample, SIZE, shape, 13);
        let coordinates = basis.coordinates(&sample, SIZE, (0, 0), (50, 1));
        let wanted = strip(&sample, shape, (8, 5));
        let bounds = bounds(&basis, &coordinates, &wanted);
        for x in (0..50).step_by(2) {
            let bound = bounds(x as usize);
            let error = error(&strip(&sample, shape, (x, 0)), &wanted) as f32;
            let squares = 36.0 * 2.0 * 120.0 * 120.0;
            assert!(bound >= error - 4.0 * basis.margin * squares, "{x}: {bound} {error}");
        }
    }

    #[test]
    fn directions_are_orthonormal() {
        for (name, sample) in pictures() {
            for shape in SHAPES {
                let basis = StripBasis::new(&sample, SIZE, shape, 45);
                let rows: Vec<&[f32]> = basis.weights.chunks(shape.dimension()).collect();
                assert_eq!(rows.len(), 45);
                for (i, a) in rows.iter().enumerate() {
                    for (j, b) in rows[..=i].iter().enumerate() {
                        let product: f64 = a.iter().zip(*b).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum();
                        let missing = i == j && a.iter().all(|a| *a == 0.0);
                        let expected = if i == j && !missing { 1.0 } else { 0.0 };
                        assert!((product - expected).abs() < 2e-7, "{name} {shape:?} {i} {j}: {product}");
                    }
                }
            }
        }
    }

    #[test]
    fn coordinates_are_the_projections_of_the_strips() {
        let (first, count) = ((3, 2), (19, 7));
        for (name, sample) in pictures() {
            for shape in &SHAPES[..5] {
                let basis = StripBasis::new(&sample, SIZE, *shape, 13);
                let coordinates = basis.coordinates(&sample, SIZE, first, count);
                assert_eq!(coordinates.len(), 4 * 19 * 7);
                for p in 0..count.0 * count.1 {
                    let strip = strip(&sample, *shape, (first.0 + p % count.0, first.1 + p / count.0));
                    let (factors, constant) = template(&basis, &strip);
                    let expected = factors[..15].iter().map(|f| f / -2.0).chain([constant]);
                    let size = constant.sqrt();
                    for (k, (c, expected)) in at(&coordinates, 133, p as usize).zip(expected).enumerate() {
                        // The last is a square, and the one before is the root of a difference.
                        let most = [1e-5 * size, 2e-3 * size, 1e-6 * constant][k.saturating_sub(13)];
                        assert!((c - expected).abs() <= most, "{name} {shape:?} {p} {k}: {c} {expected}");
                    }
                }
            }
        }
    }

    #[test]
    fn how_the_work_is_divided_changes_no_bit() {
        let sample = textured();
        for shape in SHAPES {
            let basis = StripBasis::new(&sample, SIZE, shape, 13);
            assert_eq!(basis, StripBasis::new(&sample, SIZE, shape, 13));
            let (columns, rows) = count(shape);
            let all = basis.coordinates(&sample, SIZE, (0, 0), (columns, rows));
            for (y, row) in (0..).zip(all.chunks(columns as usize)).take(rows as usize) {
                let alone = basis.coordinates(&sample, SIZE, (0, y), (columns, 1));
                assert_eq!(row, &alone[..columns as usize], "{shape:?} {y}");
            }
        }
    }

    #[test]
    fn packed_coordinates_by_hand() {
        let mut layers = [[0.0; 4]; 4];
        layers[0] = [32_766.0, 2.5, 3.5, -2.5];
        layers[1] = [-7.6, 0.4, -0.6, 1.0];
        layers[3] = [-3.0, 0.0, 5.1, 1234.5];
        let packed = Packed::new(&layers, 1);
        assert_eq!(packed.step, 1.0);
        let pair = |low: i16, high: i16| u32::from(low as u16) | u32::from(high as u16) << 16;
        assert_eq!(packed.texels[0], [pair(32_766, 2), pair(4, -2), pair(-8, 0), pair(-1, 1)]);
        // c is rounded to the nearest, what is left out up.
        assert_eq!(packed.texels[1], [0, 0, pair(-3, 6), 1234.5f32.to_bits()]);
    }

    #[test]
    fn a_truncated_basis_has_the_first_directions() {
        let sample = textured();
        let shape = SHAPES[0];
        let whole = StripBasis::new(&sample, SIZE, shape, 45);
        for components in [5, 13, 29] {
            let mut basis = whole.clone();
            basis.truncate(components);
            assert_eq!((basis.components, basis.margin), (components, margin(shape, components)));
            assert_eq!(basis.weights, whole.weights[..components * shape.dimension()]);
            let [all, first] = [&whole, &basis].map(|basis| basis.coordinates(&sample, SIZE, (3, 4), (1, 1)));
            assert_eq!(first.len(), components.div_ceil(4));
            assert!(at(&first, 1, 0).take(components).eq(at(&all, 1, 0).take(components)), "{components}");
            assert_eq!(first.as_flattened()[components], 0.0);
        }
        let mut same = whole.clone();
        same.truncate(46);
        assert_eq!(same, whole);
    }

    #[test]
    fn what_is_left_out_by_hand() {
        let one = StripShape { width: 1, height: 1 };
        let bits = |x, y| random::bits(3, x, y);
        // Two colours that vary alone: the first direction holds half, the second the rest.
        let sample = picture(|x, y| [255 * (bits(x, y) & 1), 255 * (bits(x, y) >> 9 & 1), 7]);
        let basis = StripBasis::new(&sample, SIZE, one, 5);
        let left_out = [0, 1, 2, 3, 5].map(|count| basis.left_out(count));
        assert_eq!(left_out[0], 1.0);
        assert!((0.4..0.55).contains(&left_out[1]), "{left_out:?}");
        assert!(left_out[2..].iter().all(|share| share.abs() < 1e-5), "{left_out:?}");
    }
}
