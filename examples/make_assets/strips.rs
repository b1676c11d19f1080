//! The three paint strips: which colours, and where the strokes go.
//!
//! A strip shows a paint from its dark on the left to its light on the right. Strokes are laid in layers, broad ones
//! first; within a layer they lie on a jittered grid in random order, so that everything is covered and no order
//! shows. A stroke's two paints come from the strip's colour path a little to the dark and a little to the light
//! side of where the stroke is.

use super::brush::{Canvas, Stroke};
use super::curve::spline;
use super::pigment::{from_bytes, mix, Colour};
use super::random::Random;
use glam::DVec2;

/// Size of each strip in pixels.
pub const SIZE: (usize, usize) = (512, 128);

/// A strip to paint.
pub struct Recipe {
    /// The file's name without its ending.
    pub name: &'static str,
    pub seed: u64,
    /// Colours at even places from left to right.
    colours: &'static [[u8; 3]],
    layers: &'static [Layer],
}

/// One layer of strokes; lengths in pixels.
struct Layer {
    /// Side lengths of the grid's cells: one stroke each.
    spacing: [f64; 2],
    width: [f64; 2],
    length: [f64; 2],
    direction: Direction,
    /// How far sideways a path is bent at most, relative to its length.
    bend: f64,
    /// How far along the colour path (0..1) a stroke may stray, and how far its two paints lie apart.
    stray: f64,
    apart: f64,
    load: [f64; 2],
}

enum Direction {
    Any,
    /// About this vector, give or take this much to either side per length.
    About([f64; 2], f64),
}

/// The strips.
pub const RECIPES: [Recipe; 3] = [
    Recipe {
        name: "strip_green_yellow",
        seed: 5,
        colours: &[
            [8, 38, 46],
            [10, 58, 52],
            [18, 82, 50],
            [44, 108, 38],
            [84, 136, 30],
            [128, 160, 34],
            [172, 182, 44],
            [208, 204, 62],
            [232, 222, 92],
            [244, 234, 128],
            [250, 243, 164],
        ],
        layers: &[
            Layer {
                spacing: [13.0, 13.0],
                width: [14.0, 20.0],
                length: [24.0, 40.0],
                direction: Direction::Any,
                bend: 0.15,
                stray: 0.12,
                apart: 0.20,
                load: [0.9, 1.2],
            },
            Layer {
                spacing: [12.0, 12.0],
                width: [8.0, 15.0],
                length: [16.0, 32.0],
                direction: Direction::Any,
                bend: 0.18,
                stray: 0.14,
                apart: 0.24,
                load: [0.5, 1.2],
            },
        ],
    },
    Recipe {
        name: "strip_dark_red",
        seed: 4,
        colours: &[
            [26, 10, 12],
            [50, 10, 14],
            [82, 10, 18],
            [116, 14, 24],
            [148, 20, 32],
            [174, 36, 46],
            [194, 64, 66],
            [212, 96, 92],
            [226, 130, 120],
            [238, 164, 150],
            [246, 194, 180],
        ],
        layers: &[
            Layer {
                spacing: [9.0, 34.0],
                width: [10.0, 16.0],
                length: [60.0, 100.0],
                direction: Direction::About([0.0, 1.0], 0.30),
                bend: 0.08,
                stray: 0.13,
                apart: 0.20,
                load: [0.9, 1.2],
            },
            Layer {
                spacing: [8.0, 26.0],
                width: [6.0, 12.0],
                length: [44.0, 86.0],
                direction: Direction::About([0.08, 1.0], 0.34),
                bend: 0.10,
                stray: 0.15,
                apart: 0.22,
                load: [0.5, 1.15],
            },
        ],
    },
    Recipe {
        name: "strip_red_yellow",
        seed: 41,
        colours: &[
            [44, 8, 16],
            [78, 8, 16],
            [118, 12, 16],
            [160, 22, 14],
            [196, 42, 12],
            [220, 74, 12],
            [234, 110, 16],
            [242, 146, 26],
            [247, 180, 44],
            [250, 208, 76],
            [252, 232, 122],
        ],
        layers: &[
            Layer {
                spacing: [12.0, 15.0],
                width: [12.0, 18.0],
                length: [34.0, 62.0],
                direction: Direction::About([0.7, 1.0], 0.25),
                bend: 0.12,
                stray: 0.13,
                apart: 0.20,
                load: [0.9, 1.2],
            },
            Layer {
                spacing: [10.0, 15.0],
                width: [7.0, 14.0],
                length: [22.0, 50.0],
                direction: Direction::About([0.7, 1.0], 0.35),
                bend: 0.16,
                stray: 0.15,
                apart: 0.22,
                load: [0.5, 1.15],
            },
        ],
    },
];

impl Recipe {
    /// Paints the strip: rows of RGB bytes, and the number of strokes.
    pub fn paint(&self) -> (Vec<u8>, usize) {
        let mut random = Random::new(self.seed);
        let path = ColourPath::new(self.colours);
        // The ground is a thin, darker wash.
        let ground = |t: f64| mix(path.at(t), path.at(t - 0.25), 0.5);
        let mut canvas = Canvas::new(SIZE.0, SIZE.1, ground, &mut random);
        let mut count = 0;
        for layer in self.layers {
            for (middle, stray) in layer.places(&mut random) {
                canvas.lay(&layer.stroke(middle, stray, &path, &mut random), &mut random);
                count += 1;
            }
        }
        (canvas.render(), count)
    }
}

impl Layer {
    /// The middles of the strokes in the order of painting, reaching a little over the edges, and how far each
    /// stroke strays along the colour path, as a part of the most (-1..1).
    fn places(&self, random: &mut Random) -> Vec<(DVec2, f64)> {
        let [dx, dy] = self.spacing;
        let (columns, rows) = ((SIZE.0 as f64 / dx).ceil() as usize + 2, (SIZE.1 as f64 / dy).ceil() as usize + 2);
        let mut places = Vec::new();
        for column in 0..columns {
            // Each column of the grid gets darker and lighter strokes alike, so that the strip lightens steadily.
            let mut strays: Vec<f64> =
                (0..rows).map(|i| (2.0 * i as f64 + 1.0 + random.range(-1.0, 1.0)) / rows as f64 - 1.0).collect();
            random.shuffle(&mut strays);
            for (row, stray) in strays.into_iter().enumerate() {
                let x = column as f64 - 0.5 + 0.9 * random.range(-0.5, 0.5);
                let y = row as f64 - 0.5 + 0.9 * random.range(-0.5, 0.5);
                places.push((DVec2::new(x * dx, y * dy), stray));
            }
        }
        random.shuffle(&mut places);
        places
    }

    fn stroke(&self, middle: DVec2, stray: f64, path: &ColourPath, random: &mut Random) -> Stroke {
        let along = match self.direction {
            Direction::Any => random.direction(),
            Direction::About([x, y], give) => {
                let about = DVec2::new(x, y).normalize();
                let along = (about + about.perp() * (give * random.spread())).normalize();
                // Hands draw strokes either way.
                if random.range(0.0, 1.0) < 0.3 {
                    -along
                } else {
                    along
                }
            }
        };
        let half = along * (random.range(self.length[0], self.length[1]) * 0.5);
        let bend = half.perp() * (2.0 * self.bend * random.spread());
        let t = middle.x / SIZE.0 as f64 + self.stray * stray;
        let apart = self.apart * random.range(0.3, 1.0) * if random.range(0.0, 1.0) < 0.5 { -0.5 } else { 0.5 };
        Stroke {
            path: [middle - half, middle + bend * 2.0, middle + half],
            width: random.range(self.width[0], self.width[1]),
            paints: [path.at(t - apart), path.at(t + apart)],
            load: random.range(self.load[0], self.load[1]),
        }
    }
}

/// A smooth curve through a recipe's colours.
struct ColourPath(Vec<[f64; 3]>);

impl ColourPath {
    const STEPS: usize = 16;

    fn new(colours: &[[u8; 3]]) -> Self {
        let knots: Vec<[f64; 3]> = colours.iter().map(|&rgb| from_bytes(rgb).to_array()).collect();
        Self(spline(&knots, Self::STEPS))
    }

    /// The colour at `t`, 0 at the dark end and 1 at the light one.
    fn at(&self, t: f64) -> Colour {
        let place = t.clamp(0.0, 1.0) * (self.0.len() - 1) as f64;
        let i = (place as usize).min(self.0.len() - 2);
        Colour::from(self.0[i]).lerp(Colour::from(self.0[i + 1]), place - i as f64)
    }
}
