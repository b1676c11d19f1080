//! The peer: the same search in plain code.

use crate::Result;
use impasto::synthesis::params::{Layout, QuiltParams};
use std::time::Instant;

/// Quilts once, and says how long it took.
pub fn report(texels: &[[u8; 4]], side: u32, to: u32, params: &QuiltParams) -> Result {
    let layout = Layout::new(params, (to, to))?;
    let start = Instant::now();
    let pixels = quilt(texels, side as usize, params, &layout);
    let time = start.elapsed().as_secs_f64();
    let sum: u64 = pixels.iter().map(|p| u64::from(p[0])).sum();
    println!("  plain CPU search, one core: {time:.3} s, 1 round (checksum {sum})");
    Ok(())
}

/// For every block in raster order the overlap error at every position, plain loops on one core that the compiler may
/// vectorise; the best position is pasted without a cut.
fn quilt(sample: &[[u8; 4]], side: usize, params: &QuiltParams, layout: &Layout) -> Vec<[u8; 4]> {
    let (width, height) = (layout.output.0 as usize, layout.output.1 as usize);
    let planes: Vec<Vec<i32>> = (0..3).map(|c| sample.iter().map(|p| i32::from(p[c])).collect()).collect();
    let mut out = vec![vec![0i32; width * height]; 3];
    let overlap = params.overlap_px as usize;
    let last = side - params.block_px as usize;
    for block in &layout.placements {
        let (x, y) = (block.x as usize, block.y as usize);
        let (w, h) = (block.width as usize, block.height as usize);
        let mut best = (i32::MAX, 0, 0);
        for sy in 0..=last {
            for sx in 0..=last {
                let mut error = 0;
                for dy in 0..h {
                    let run = if dy < overlap && y > 0 {
                        w
                    } else if x > 0 {
                        overlap.min(w)
                    } else {
                        0
                    };
                    for (plane, out) in planes.iter().zip(&out) {
                        let a = &plane[(sy + dy) * side + sx..][..run];
                        let b = &out[(y + dy) * width + x..][..run];
                        error += a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<i32>();
                    }
                }
                if error < best.0 {
                    best = (error, sx, sy);
                }
            }
        }
        for dy in 0..h {
            for (plane, out) in planes.iter().zip(&mut out) {
                let from = &plane[(best.2 + dy) * side + best.1..][..w];
                out[(y + dy) * width + x..][..w].copy_from_slice(from);
            }
        }
    }
    (0..width * height).map(|i| [out[0][i] as u8, out[1][i] as u8, out[2][i] as u8, 255]).collect()
}
