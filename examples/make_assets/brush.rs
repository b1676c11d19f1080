//! A canvas, and a brush that leaves the marks of its bristles on it.
//!
//! A brush is loaded with two paints that have not been stirred together. Each bristle has a place across the brush,
//! its own mixture and its own load; neighbouring bristles stick together in clumps that share both. On its way a
//! bristle gives off paint until it is dry, and then catches only on the raised parts of what lies beneath, so that
//! strokes break up towards their ends; it also takes up some of the wet paint that it passes through. What it
//! leaves is a colour and a thickness: a fine ridge under each clump, and a rim of paint pushed to the stroke's
//! edges and its end. Light from the upper left on that relief is drawn last.

use super::pigment::{mix, Colour};
use super::random::{Noise, Random};
use glam::{DVec2, DVec3};

/// Canvas cells along either side of an image pixel: fine enough for single bristles.
pub const SCALE: usize = 2;

/// Radius of a bristle's mark, in canvas cells.
const BRISTLE_RADIUS: f64 = 1.35;

/// Distance between the marks of a bristle, in canvas cells.
const STEP: f64 = 0.8;

/// One stroke to lay down; lengths are in image pixels.
pub struct Stroke {
    /// Start, a point that bends the path (the middle control point of a quadratic Bezier curve), end.
    pub path: [DVec2; 3],
    /// Width of the brush.
    pub width: f64,
    /// The two paints on the brush: one side has more of the first, the other of the second.
    pub paints: [Colour; 2],
    /// How much paint the brush carries: at 1 it lasts to the end, at 0.5 it is dry halfway.
    pub load: f64,
}

/// Wet paint on a primed cloth.
pub struct Canvas {
    width: usize,
    height: usize,
    colour: Vec<Colour>,
    thickness: Vec<f64>,
    /// The cloth's relief in 0..1, from its weave and irregular threads.
    grain: Vec<f64>,
}

struct Bristle {
    /// Place across the brush, -1..1.
    across: f64,
    colour: Colour,
    load: f64,
    /// The part of the stroke during which it touches.
    begin: f64,
    end: f64,
    /// How much paint it leaves, relative to the others.
    body: f64,
}

impl Canvas {
    /// A canvas for an image of `width` x `height` pixels, washed with a thin ground of `ground(x / width)`.
    pub fn new(width: usize, height: usize, ground: impl Fn(f64) -> Colour, random: &mut Random) -> Self {
        let (width, height) = (width * SCALE, height * SCALE);
        let grain: Vec<f64> = (0..width * height)
            .map(|i| {
                // Over and under: threads of three pixels, every other one up.
                let thread = |n: usize| 1.0 - ((n % 6) as f64 - 2.5).abs() / 2.5;
                let (x, y) = (i % width, i / width);
                let over = (x / 6 + y / 6) % 2 == 0;
                0.35 + 0.35 * if over { thread(x) } else { thread(y) } + 0.3 * random.range(-1.0, 1.0)
            })
            .collect();
        let colour =
            (0..width * height).map(|i| ground((i % width) as f64 / width as f64) * (0.94 + 0.12 * grain[i])).collect();
        Self { width, height, colour, thickness: grain.iter().map(|g| g * 0.2).collect(), grain }
    }

    /// Lays down one stroke.
    pub fn lay(&mut self, stroke: &Stroke, random: &mut Random) {
        let [a, b, c] = stroke.path.map(|p| p * SCALE as f64);
        let length = (a.distance(b) + b.distance(c) + a.distance(c)) * 0.5;
        let half_width = stroke.width * SCALE as f64 * 0.5;
        let mut bristles = bristles(stroke, random);
        let tremble = Noise::new(random, (length / 14.0) as usize);
        let steps = (length / STEP).ceil().max(2.0) as usize;
        for step in 0..steps {
            let t = step as f64 / (steps - 1) as f64;
            let place = a * ((1.0 - t) * (1.0 - t)) + b * (2.0 * t * (1.0 - t)) + c * (t * t);
            let along = ((b - a) * (1.0 - t) + (c - b) * t).normalize_or_zero();
            let side = along.perp();
            // The brush is set down quickly, and lifted off over the last quarter.
            let pressure = (0.55 + 6.0 * t).min(1.0) * (0.45 + 2.2 * (1.0 - t)).min(1.0);
            let spread = half_width * (0.72 + 0.28 * pressure) + 0.5 * tremble.at(t);
            for bristle in bristles.iter_mut().filter(|b| (b.begin..b.end).contains(&t)) {
                // Bristles at the sides trail behind the middle ones.
                let lag = bristle.across * bristle.across * half_width * 0.35;
                let at = place + side * (bristle.across * spread) - along * lag;
                let wet = bristle.load * pressure - t;
                let rim =
                    0.55 * ((bristle.across.abs() - 0.78) * 5.0).clamp(0.0, 1.0) + 0.5 * ((t - 0.85) * 6.0).max(0.0);
                self.touch(at, bristle, wet, bristle.body * (0.7 + rim));
            }
        }
    }

    /// One touch of one bristle; `wet` above 0 covers, below it only the heights beneath are caught.
    fn touch(&mut self, at: DVec2, bristle: &mut Bristle, wet: f64, body: f64) {
        let reach = DVec2::splat(BRISTLE_RADIUS);
        let size = DVec2::new(self.width as f64, self.height as f64);
        let low = (at - reach).floor().clamp(DVec2::ZERO, size);
        let high = (at + reach).ceil().clamp(DVec2::ZERO, size);
        for y in low.y as usize..high.y as usize {
            for x in low.x as usize..high.x as usize {
                let off = DVec2::new(x as f64 + 0.5, y as f64 + 0.5) - at;
                let near = 1.0 - off.length_squared() / (BRISTLE_RADIUS * BRISTLE_RADIUS);
                if near <= 0.0 {
                    continue;
                }
                let i = y * self.width + x;
                let relief = 0.6 * self.grain[i] + 0.4 * self.thickness[i].min(1.0);
                let catch = (0.5 + 2.2 * wet + 0.9 * (relief - 0.5)).clamp(0.0, 1.0);
                let cover = near * catch * 0.75;
                self.colour[i] = self.colour[i].lerp(bristle.colour, cover);
                let target = body * (0.35 + 0.65 * near) * (0.5 + 0.5 * wet.clamp(0.0, 1.0)) + 0.25 * self.thickness[i];
                self.thickness[i] += (target - self.thickness[i]) * cover;
            }
        }
        // Wet paint is taken up from under the bristle's tip.
        if at.cmpge(DVec2::ZERO).all() && at.cmplt(size).all() {
            let here = self.colour[at.y as usize * self.width + at.x as usize];
            bristle.colour = mix(bristle.colour, here, 0.012);
        }
    }

    /// The finished picture, lit from the upper left, as rows of RGB bytes.
    pub fn render(&self) -> Vec<u8> {
        let (columns, rows) = (self.width / SCALE, self.height / SCALE);
        let mut bytes = Vec::with_capacity(columns * rows * 3);
        for pixel in 0..columns * rows {
            let mut sum = DVec3::ZERO;
            for cell in 0..SCALE * SCALE {
                sum += self.lit(pixel % columns * SCALE + cell % SCALE, pixel / columns * SCALE + cell / SCALE);
            }
            let mean = sum / (SCALE * SCALE) as f64;
            bytes.extend(mean.to_array().map(|v| (v.clamp(0.0, 1.0) * 255.0).round() as u8));
        }
        bytes
    }

    /// A cell's colour with its highlight or shadow.
    fn lit(&self, x: usize, y: usize) -> Colour {
        let height = |dx: isize, dy: isize| {
            let x = (x as isize + dx).clamp(0, self.width as isize - 1) as usize;
            let y = (y as isize + dy).clamp(0, self.height as isize - 1) as usize;
            self.thickness[y * self.width + x]
        };
        // A slope that rises to the right and downwards faces the light.
        let facing = (height(1, 0) - height(-1, 0)) + (height(0, 1) - height(0, -1));
        let facing = (facing * RELIEF).clamp(-0.30, 0.30);
        let colour = self.colour[y * self.width + x];
        if facing < 0.0 {
            colour * (1.0 + facing)
        } else {
            // Wet paint shines: part of the highlight is white.
            colour * (1.0 + 0.6 * facing) + (DVec3::ONE - colour) * (0.25 * facing)
        }
    }
}

/// How strongly the relief shows.
const RELIEF: f64 = 0.40;

fn bristles(stroke: &Stroke, random: &mut Random) -> Vec<Bristle> {
    let count = (stroke.width * SCALE as f64 * 0.62).max(3.0) as usize;
    let clumps = (stroke.width * 0.45) as usize + 2;
    let (mixture, fullness, reach) =
        (Noise::new(random, clumps), Noise::new(random, clumps * 2), Noise::new(random, clumps * 2));
    (0..count)
        .map(|i| {
            let place = (i as f64 + 0.5 + 0.35 * random.spread()) / count as f64;
            let across = 2.0 * place - 1.0;
            let full = fullness.at(place);
            let share = 0.5 + 0.25 * across + 0.55 * mixture.at(place) + 0.12 * random.spread();
            let tone = 1.0 + 0.03 * random.spread() + 0.03 * full;
            Bristle {
                across,
                colour: (mix(stroke.paints[0], stroke.paints[1], share) * tone).clamp(DVec3::ZERO, DVec3::ONE),
                load: stroke.load * (1.15 + 0.35 * full),
                begin: (0.05 + 0.05 * reach.at(1.0 - place)).max(0.0) * random.range(0.3, 1.0),
                end: 0.90 + 0.10 * reach.at(place) + 0.06 * random.spread(),
                body: 0.65 + 0.30 * full + 0.10 * random.spread(),
            }
        })
        .collect()
}
