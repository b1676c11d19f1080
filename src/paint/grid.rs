//! A strip that shows how texture lies on a model (thesis, figure 5.1).

use super::sample::PaintSample;

const SIZE: (u32, u32) = (512, 128);
/// Distance of the lines, pixels; it divides the height, so that the strip repeats along it.
const STEP: u32 = 32;

impl PaintSample {
    /// A grid of dark lines, 16 by 4 fields, on grey that grows lighter with the shade, and a dotted blue line at the
    /// shade 1/2: along it the light is constant, however the rows of the strip are shifted (figure 5.1). 512x128
    /// pixels; its rows repeat.
    pub fn grid() -> Self {
        let pixel = |x: u32, y: u32| {
            let middle = x.abs_diff(SIZE.0 / 2) <= 2;
            if middle && y % 8 < 5 {
                return [0.1, 0.2, 0.9];
            }
            let line = x % STEP < 2 || y % STEP < 2;
            let ground = 0.45 + 0.55 * x as f32 / (SIZE.0 - 1) as f32;
            [if line { 0.3 * ground } else { ground }; 3]
        };
        let pixels = (0..SIZE.1).flat_map(|y| (0..SIZE.0).map(move |x| pixel(x, y))).collect();
        PaintSample::from_parts(SIZE.0, SIZE.1, pixels)
    }
}
