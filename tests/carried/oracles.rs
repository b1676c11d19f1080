//! Carrying and settling told plainly, pixel by pixel.

use impasto::paint::Trajectory;
use impasto::synthesis::repair_oracle::CarriedTexture;

/// Steps of a texel in a place, and of a pixel in motion.
const STEPS: i32 = 64;

/// What carrying goes by; pictures are row by row.
#[derive(Clone, Copy)]
pub struct Moved<'a> {
    pub size: (u32, u32),
    /// As uploaded: twice 15 bits, x low, 16,384 + 64 times the way to where the surface was; the highest bit if that
    /// was in sight; 0 where nothing is known.
    pub motion: &'a [u32],
    /// The number of each pixel's paint, from 1; 0 is background.
    pub paint_at: &'a [u32],
    /// The places of the frame before.
    pub places: &'a [Option<(u32, u32)>],
}

impl Moved<'_> {
    fn index(&self, (x, y): (i32, i32)) -> Option<usize> {
        let inside = (0..self.size.0 as i32).contains(&x) && (0..self.size.1 as i32).contains(&y);
        inside.then(|| (y * self.size.0 as i32 + x) as usize)
    }

    fn place(&self, at: (i32, i32)) -> Option<(i32, i32)> {
        let (x, y) = self.places[self.index(at)?]?;
        Some((x as i32, y as i32))
    }

    /// The motion of a pixel of a paint in steps, and whether the frame before showed its surface.
    fn motion_of(&self, at: (i32, i32), paint: u32) -> Option<((i32, i32), bool)> {
        let pixel = self.index(at).filter(|&pixel| self.paint_at[pixel] == paint)?;
        let word = self.motion[pixel];
        let way = |bits: u32| (bits & 0x7fff) as i32 - 16_384;
        (word != 0).then_some(((way(word), way(word >> 15)), word >> 31 == 1))
    }

    /// The way from a pixel to the one of its paint, itself if it can be, whose surface was in sight and that moves
    /// most alike, and that one's motion.
    fn in_sight(&self, (x, y): (i32, i32), paint: u32) -> Option<((i32, i32), (i32, i32))> {
        let own = self.motion_of((x, y), paint);
        if let Some((way, true)) = own {
            return Some(((0, 0), way));
        }
        let around = (1..=8).flat_map(|r| [(r, 0), (-r, 0), (0, r), (0, -r)].map(|shift| (r, shift)));
        let alike = around.filter_map(|(r, shift)| {
            let (way, shown) = self.motion_of((x + shift.0, y + shift.1), paint)?;
            let apart = own.map_or(0, |(own, _)| (way.0 - own.0).abs() + (way.1 - own.1).abs());
            (shown && apart + r < STEPS).then_some((apart + r, (shift, way)))
        });
        alike.min_by_key(|(cost, _)| *cost).map(|(_, found)| found)
    }

    /// How places change from a pixel with one to the next along an axis.
    fn slope(&self, from: (i32, i32), axis: (i32, i32), forward_first: bool) -> (i32, i32) {
        let step = |sign: i32| {
            let (here, there) = (self.place(from)?, self.place((from.0 + sign * axis.0, from.1 + sign * axis.1))?);
            let change = (sign * (there.0 - here.0), sign * (there.1 - here.1));
            let off = [change.0 - STEPS * axis.0, change.1 - STEPS * axis.1];
            off.iter().all(|off| off.abs() <= 48).then_some(change)
        };
        let signs = if forward_first { [1, -1] } else { [-1, 1] };
        signs.into_iter().find_map(step).unwrap_or((STEPS * axis.0, STEPS * axis.1))
    }
}

/// What is carried to the pixels of a paint. `limits` are the least and most that a step of a pixel may become in the
/// sample, in steps.
pub fn carry(moved: &Moved, paint: u32, sample: (u32, u32), limits: (u32, u32)) -> Vec<Option<CarriedTexture>> {
    let pixels = (0..moved.size.1 as i32).flat_map(|y| (0..moved.size.0 as i32).map(move |x| (x, y)));
    pixels.map(|at| carry_to(moved, at, paint, sample, limits)).collect()
}

fn carry_to(
    moved: &Moved,
    at: (i32, i32),
    paint: u32,
    sample: (u32, u32),
    limits: (u32, u32),
) -> Option<CarriedTexture> {
    moved.index(at).filter(|&pixel| moved.paint_at[pixel] == paint)?;
    let (shift, way) = moved.in_sight(at, paint)?;
    let nearest = ((way.0 + STEPS / 2).div_euclid(STEPS), (way.1 + STEPS / 2).div_euclid(STEPS));
    let rest = (way.0 - STEPS * nearest.0, way.1 - STEPS * nearest.1);
    let from = (at.0 + shift.0 + nearest.0, at.1 + shift.1 + nearest.1);
    let (place, misfit) = match moved.place(from) {
        Some(here) => {
            let right = moved.slope(from, (1, 0), rest.0 >= 0);
            let down = moved.slope(from, (0, 1), rest.1 >= 0);
            let go = |right: i32, down: i32| (right * rest.0 + down * rest.1 + STEPS / 2).div_euclid(STEPS);
            ((here.0 + go(right.0, down.0), here.1 + go(right.1, down.1)), !fits(right, down, limits))
        }
        None => {
            // Texture beside it goes on to here.
            let beside = [(1, 0), (-1, 0), (0, 1), (0, -1)].into_iter().find_map(|(dx, dy)| {
                let (x, y) = moved.place((from.0 + dx, from.1 + dy))?;
                Some((x - STEPS * dx, y - STEPS * dy))
            });
            let (x, y) = beside?;
            ((x + rest.0, y + rest.1), false)
        }
    };
    let place = (place.0 - STEPS * shift.0, place.1 - STEPS * shift.1);
    let inside = |place: i32, side: u32| (0..=STEPS * (side as i32 - 1)).contains(&place);
    let in_sample = inside(place.0, sample.0) && inside(place.1, sample.1);
    in_sample.then_some(CarriedTexture { place: (place.0 as u32, place.1 as u32), misfit })
}

/// Whether the singular values of the matrix with these columns are within the limits, and its turn within 30 degrees,
/// of which 15/26 is the tangent.
fn fits(right: (i32, i32), down: (i32, i32), (least, most): (u32, u32)) -> bool {
    let dot = |a: (i32, i32), b: (i32, i32)| i64::from(a.0 * b.0 + a.1 * b.1);
    let (xx, xy, yy) = (dot(right, right), dot(right, down), dot(down, down));
    // Limit^2 - J^T J, of either sign, has no negative eigenvalue.
    let beyond = |limit: u32, sign: i64| {
        let square = i64::from(limit) * i64::from(limit);
        let (a, c) = (sign * (square - xx), sign * (square - yy));
        a + c >= 0 && a * c - xy * xy >= 0
    };
    let upright = (right.1 - down.0).abs() * 26 <= (right.0 + down.1) * 15;
    beyond(most, 1) && beyond(least, -1) && upright
}

/// The weight of a texel `d` away, by cubic convolution (Keys 1981, a = -0.9).
fn keys(d: f64) -> f64 {
    const A: f64 = -0.9;
    match d.abs() {
        d if d <= 1.0 => ((A + 2.0) * d - (A + 3.0)) * d * d + 1.0,
        d if d < 2.0 => A * (((d - 5.0) * d + 8.0) * d - 4.0),
        _ => 0.0,
    }
}

/// The texture difference at a place, from `texels` (8-bit, of the texture's size): of the 4 x 4 texels around it all
/// but the corners, which count nothing.
fn difference_at(texels: &[[u8; 4]], (width, height): (u32, u32), place: (u32, u32)) -> [f64; 3] {
    let (x, y) = (f64::from(place.0) / f64::from(STEPS), f64::from(place.1) / f64::from(STEPS));
    let texel = |x: f64, y: f64| {
        let clamped = |at: f64, side: u32| at.clamp(0.0, f64::from(side - 1)) as usize;
        texels[clamped(y, height) * width as usize + clamped(x, width)]
    };
    let (mut sum, mut weights) = ([0.0; 3], 0.0);
    for (i, j) in (-1..=2).flat_map(|j| (-1..=2).map(move |i| (i, j))) {
        let outer = |k: i32| k == -1 || k == 2;
        if outer(i) && outer(j) {
            continue;
        }
        let (at_x, at_y) = (x.floor() + f64::from(i), y.floor() + f64::from(j));
        let weight = keys(x - at_x) * keys(y - at_y);
        let texel = texel(at_x, at_y);
        sum = std::array::from_fn(|c| sum[c] + weight * f64::from(texel[c]));
        weights += weight;
    }
    sum.map(|sum| 2.0 * sum / weights / 255.0 - 1.0)
}

/// The pixel of the frame with this tone and place.
pub fn settled_pixel(
    texels: &[[u8; 4]],
    size: (u32, u32),
    trajectory: &Trajectory,
    tone: f32,
    place: (u32, u32),
) -> [u8; 4] {
    let difference = difference_at(texels, size, place);
    let color = trajectory.at(tone);
    let value = |c: usize| ((f64::from(color[c]) + difference[c]).clamp(0.0, 1.0) * 255.0).round() as u8;
    [value(0), value(1), value(2), 255]
}
