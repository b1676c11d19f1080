//! What a quilting is asked for, where its blocks lie, and what was chosen for each of them.
//!
//! Plain data, shared by the GPU stages and by the CPU oracle: [`QuiltParams`] goes in, [`Layout`] says which blocks
//! there are, in which order they are placed and which of them may be placed at once, and one [`BlockRecord`] per
//! placed block tells afterwards where in the sample it was taken from. Method: A. Efros and W. Freeman, "Image
//! Quilting for Texture Synthesis and Transfer", SIGGRAPH 2001; thesis 3.2.2.

use crate::error::{Error, Result};

/// Largest side of a sample, in pixels.
pub(crate) const MAX_SAMPLE_PX: u32 = 4096;
/// Most blocks of an output. At the default block and overlap the largest output has 400,000.
const MAX_BLOCKS: usize = 1 << 20;
/// Largest side of an output, in pixels.
const MAX_OUTPUT_PX: u32 = 16384;

/// How to quilt.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QuiltParams {
    /// Side of the square blocks, in pixels: 4 to 64.
    pub block_px: u32,
    /// By how many pixels neighbouring blocks overlap: 1 to half of `block_px`.
    pub overlap_px: u32,
    /// How much worse than the best position a position may fit and still be chosen, as a fraction of the least overlap
    /// error: 0 to 10, in steps of 1/10000. Efros and Freeman use 0.1.
    pub tolerance: f32,
    /// Picks among the positions that fit; the same seed gives the same bytes. The GPU takes it when recording.
    pub seed: u32,
    /// Whether the output repeats without a seam, its left edge joining its right one and its top its bottom.
    pub tileable: bool,
}

impl Default for QuiltParams {
    fn default() -> Self {
        QuiltParams { block_px: 32, overlap_px: 6, tolerance: 0.1, seed: 1, tileable: false }
    }
}

impl QuiltParams {
    /// Checks every field, and that a sample and an output of these sizes (width, height in pixels) can be used.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a field outside of its range, a sample with a side outside of `block_px..=4096`, an
    /// output with a side outside of `1..=16384`, and a tileable output that its blocks cannot cover (see
    /// [`Layout::new`]).
    pub fn validate(&self, sample: (u32, u32), output: (u32, u32)) -> Result<()> {
        if !(0.0..=10.0).contains(&self.tolerance) {
            return Err(Error::parameter("tolerance", self.tolerance, "0 to 10"));
        }
        self.axes(output)?;
        for (name, side) in [("sample width", sample.0), ("sample height", sample.1)] {
            if !(self.block_px..=MAX_SAMPLE_PX).contains(&side) {
                let allowed = format!("{} (block_px) to {MAX_SAMPLE_PX} px", self.block_px);
                return Err(Error::parameter(name, side, allowed));
            }
        }
        Ok(())
    }

    /// The tolerance in units of 1/10000, rounded down: what the integer arithmetic of the choice uses.
    ///
    /// The thousandth of a unit that is added first lifts decimal fractions such as 0.7, which `f32` can only hold a
    /// little below their value, back to what the person wrote.
    pub fn tolerance_e4(&self) -> u32 {
        (f64::from(self.tolerance) * 10_000.0 + 1e-3).floor() as u32
    }

    /// The spans of the columns and of the rows, after checking what they depend on.
    fn axes(&self, output: (u32, u32)) -> Result<[Vec<Span>; 2]> {
        if !(4..=64).contains(&self.block_px) {
            return Err(Error::parameter("block_px", self.block_px, "4 to 64"));
        }
        if !(1..=self.block_px / 2).contains(&self.overlap_px) {
            let allowed = format!("1 to {} (half of block_px)", self.block_px / 2);
            return Err(Error::parameter("overlap_px", self.overlap_px, allowed));
        }
        let axes = [self.spans("output width", output.0)?, self.spans("output height", output.1)?];
        let blocks = axes[0].len() * axes[1].len();
        if blocks > MAX_BLOCKS {
            let allowed = format!("at most {MAX_BLOCKS}: a smaller output, a larger block_px or a smaller overlap_px");
            return Err(Error::parameter("number of blocks", blocks, allowed));
        }
        Ok(axes)
    }

    /// Cuts one side of the output into the spans of its columns (or rows). Block and overlap are known to be in range.
    fn spans(&self, name: &'static str, side: u32) -> Result<Vec<Span>> {
        if !(1..=MAX_OUTPUT_PX).contains(&side) {
            return Err(Error::parameter(name, side, format!("1 to {MAX_OUTPUT_PX} px")));
        }
        let (block, overlap) = (self.block_px, self.overlap_px);
        let step = block - overlap;
        if !self.tileable {
            let count = side.saturating_sub(overlap).div_ceil(step).max(1);
            return Ok((0..count).map(|c| Span { start: c * step, length: block.min(side - c * step) }).collect());
        }
        // The fewest spans that close the ring. Fewer would be longer than a block; more would only be narrower.
        let count = side.div_ceil(step).max(2);
        let start = |c: u32| (u64::from(c) * u64::from(side) / u64::from(count)) as u32;
        let advances = || (0..count).map(|c| start(c + 1) - start(c));
        if advances().any(|advance| advance < overlap || advance + overlap > block) {
            let least = 2 * overlap;
            let allowed = format!(
                "at least {least} px and divisible into near-equal parts of {overlap} to {step} px for a tileable \
                 output (block_px {block}, overlap_px {overlap})"
            );
            return Err(Error::parameter(name, side, allowed));
        }
        Ok((0..count).zip(advances()).map(|(c, advance)| Span { start: start(c), length: advance + overlap }).collect())
    }
}

/// A stretch of one side of the output; a tileable layout's last one runs past the end and wraps round.
#[derive(Debug, Clone, Copy)]
struct Span {
    start: u32,
    length: u32,
}

/// Where a block lies in the output, in pixels.
///
/// In a plain layout the rectangle lies inside of the output. In a tileable one its coordinates are taken modulo the
/// output's size, and it never meets itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Placement {
    /// Row in the grid of blocks, from the top.
    pub row: u32,
    /// Column in the grid of blocks, from the left.
    pub col: u32,
    /// Left edge.
    pub x: u32,
    /// Top edge.
    pub y: u32,
    /// Width: at most `block_px`, less where the output ends.
    pub width: u32,
    /// Height: at most `block_px`, less where the output ends.
    pub height: u32,
}

/// The grid of blocks that covers an output, and the order in which they are placed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layout {
    /// Columns of blocks.
    pub columns: u32,
    /// Rows of blocks.
    pub rows: u32,
    /// Width and height of the output in pixels.
    pub output: (u32, u32),
    /// Every block, row by row: a block's index is `row * columns + col`.
    pub placements: Vec<Placement>,
    /// The blocks' indices in placing order.
    pub order: Vec<u32>,
    /// Blocks that may be placed at once, in placing order: the blocks of one wave share no pixel, and each overlaps
    /// only earlier placed blocks of earlier waves.
    pub waves: Vec<Vec<u32>>,
}

impl Layout {
    /// Lays blocks over an output of `output` = (width, height) pixels.
    ///
    /// Plain: blocks advance by `block_px - overlap_px` from the top left corner, are clipped to the output, and are
    /// placed in raster order. With two or more columns, block (row, col) is in wave `col + 2 row`; with one, in wave
    /// `row`.
    ///
    /// Tileable: the output is divided into the fewest columns (and rows) that are at most `block_px - overlap_px`
    /// wide, and each block reaches `overlap_px` into the next column, the last one into the first. Blocks are placed
    /// along slanted lines, by (col + 2 row, row).
    ///
    /// # Errors
    /// [`Error::Parameter`] when `block_px`, `overlap_px` or a side of the output is out of range, or when a side of a
    /// tileable output cannot be divided into two or more near-equal parts of `overlap_px` to `block_px - overlap_px`
    /// px.
    pub fn new(params: &QuiltParams, output: (u32, u32)) -> Result<Layout> {
        let [across, down] = params.axes(output)?;
        let (columns, rows) = (across.len() as u32, down.len() as u32);
        let mut placements = Vec::with_capacity(across.len() * down.len());
        for (row, vertical) in (0..).zip(&down) {
            for (col, horizontal) in (0..).zip(&across) {
                let (x, y) = (horizontal.start, vertical.start);
                placements.push(Placement { row, col, x, y, width: horizontal.length, height: vertical.length });
            }
        }
        let mut order: Vec<u32> = (0..columns * rows).collect();
        if params.tileable {
            order.sort_by_key(|index| {
                let (row, col) = (index / columns, index % columns);
                (col + 2 * row, row)
            });
        }
        let waves = waves(columns, rows, params.tileable, &order);
        Ok(Layout { columns, rows, output, placements, order, waves })
    }
}

/// Puts each block into the first wave after those of the earlier blocks that it shares a pixel with.
///
/// Those are among its eight neighbours in the grid, because an overlap is at most half a block, and neighbours always
/// share a pixel.
fn waves(columns: u32, rows: u32, tileable: bool, order: &[u32]) -> Vec<Vec<u32>> {
    let beside = |at: u32, count: u32, by: i64| -> Option<u32> {
        let moved = i64::from(at) + by;
        let count = i64::from(count);
        let inside = if tileable { moved.rem_euclid(count) } else { moved };
        (0..count).contains(&inside).then_some(inside as u32)
    };
    let mut wave_of: Vec<Option<usize>> = vec![None; order.len()];
    let mut waves: Vec<Vec<u32>> = Vec::new();
    for &index in order {
        let (row, col) = (index / columns, index % columns);
        // The block itself is among the nine, but has no wave yet.
        let earlier = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))).filter_map(|(dx, dy)| {
            let neighbour = beside(row, rows, dy)? * columns + beside(col, columns, dx)?;
            wave_of[neighbour as usize]
        });
        let wave = earlier.max().map_or(0, |last| last + 1);
        if wave == waves.len() {
            waves.push(Vec::new());
        }
        waves[wave].push(index);
        wave_of[index as usize] = Some(wave);
    }
    waves
}

/// What was chosen for one placed block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BlockRecord {
    /// Row in the grid of blocks.
    pub row: u32,
    /// Column in the grid of blocks.
    pub col: u32,
    /// Left edge in the output, in pixels (the [`Placement`]'s).
    pub x: u32,
    /// Top edge in the output, in pixels (the [`Placement`]'s).
    pub y: u32,
    /// Left edge in the sample, in pixels.
    pub sx: u32,
    /// Top edge in the sample, in pixels.
    pub sy: u32,
    /// Overlap error at the chosen position: the sum of squared 8-bit RGB differences to what was painted before.
    pub error: u32,
    /// Least overlap error over all allowed positions.
    pub min_error: u32,
    /// The allowed positions: `[sx0, sy0, sx1, sy1]`, both ends included.
    pub allowed: [u32; 4],
}

#[cfg(test)]
mod tests {
    use super::*;

    fn params(block_px: u32, overlap_px: u32, tileable: bool) -> QuiltParams {
        QuiltParams { block_px, overlap_px, tileable, ..Default::default() }
    }

    /// The output pixels of a block, worked out one by one.
    fn pixels(layout: &Layout, index: u32) -> Vec<(u32, u32)> {
        let p = layout.placements[index as usize];
        let (w, h) = layout.output;
        (0..p.height).flat_map(|dy| (0..p.width).map(move |dx| ((p.x + dx) % w, (p.y + dy) % h))).collect()
    }

    /// Checks the waves against their definition, pixel by pixel and pair by pair.
    fn check_waves(layout: &Layout) -> std::result::Result<(), String> {
        let covers: Vec<Vec<(u32, u32)>> = (0..layout.columns * layout.rows).map(|b| pixels(layout, b)).collect();
        let share = |a: u32, b: u32| covers[a as usize].iter().any(|pixel| covers[b as usize].contains(pixel));
        let wave_of = |b: u32| layout.waves.iter().position(|wave| wave.contains(&b));
        for (at, &b) in layout.order.iter().enumerate() {
            let needed = layout.order[..at].iter().filter(|&&a| share(a, b)).map(|&a| wave_of(a)).max();
            let expected = needed.flatten().map_or(0, |wave| wave + 1);
            if wave_of(b) != Some(expected) {
                return Err(format!("block {b} is in wave {:?}, expected {expected}", wave_of(b)));
            }
        }
        let in_waves: usize = layout.waves.iter().map(Vec::len).sum();
        (in_waves == layout.order.len()).then_some(()).ok_or_else(|| "a block is in two waves".into())
    }

    #[test]
    fn tolerance_is_what_was_written_in_ten_thousandths() {
        let cases = [(0.0, 0), (0.00009, 0), (0.0001, 1), (0.1, 1000), (0.3, 3000), (0.7, 7000), (10.0, 100_000)];
        for (tolerance, expected) in cases {
            assert_eq!(QuiltParams { tolerance, ..Default::default() }.tolerance_e4(), expected, "{tolerance}");
        }
    }

    #[test]
    fn every_limit_is_enforced_and_its_edge_is_allowed() {
        let ok = QuiltParams::default();
        assert!(ok.validate((32, 4096), (1, 16384)).is_ok());
        let cases = [
            (params(3, 1, false), (64, 64), (9, 9), "block_px is 3, but must be 4 to 64"),
            (params(65, 6, false), (65, 65), (9, 9), "block_px is 65, but must be 4 to 64"),
            (params(0, 0, true), (64, 64), (9, 9), "block_px is 0, but must be 4 to 64"),
            (params(9, 5, false), (64, 64), (9, 9), "overlap_px is 5, but must be 1 to 4 (half of block_px)"),
            (params(8, 0, false), (64, 64), (9, 9), "overlap_px is 0, but must be 1 to 4 (half of block_px)"),
            (ok, (31, 64), (9, 9), "sample width is 31, but must be 32 (block_px) to 4096 px"),
            (ok, (64, 4097), (9, 9), "sample height is 4097, but must be 32 (block_px) to 4096 px"),
            (ok, (64, 64), (0, 9), "output width is 0, but must be 1 to 16384 px"),
            (ok, (64, 64), (9, 16385), "output height is 16385, but must be 1 to 16384 px"),
        ];
        for (params, sample, output, message) in cases {
            let error = params.validate(sample, output).expect_err(message);
            assert_eq!(error.to_string(), message);
        }
        for tolerance in [-0.01, 10.01, f32::NAN, f32::INFINITY] {
            let error = QuiltParams { tolerance, ..ok }.validate((64, 64), (9, 9)).expect_err("tolerance");
            assert!(error.to_string().starts_with("tolerance is "), "{error}");
        }
        assert!(params(4, 2, false).validate((4, 4), (1, 1)).is_ok());
        assert!(params(64, 32, true).validate((64, 64), (64, 64)).is_ok());
    }

    #[test]
    fn plain_layout_by_hand() {
        // Step 6: columns at 0, 6, 12 reach 8, 14 and, clipped, 15. Height 8 is one block, 9 is two.
        let layout = Layout::new(&params(8, 2, false), (15, 9)).expect("layout");
        assert_eq!((layout.columns, layout.rows), (3, 2));
        let at = |index: usize| {
            let p = layout.placements[index];
            [p.row, p.col, p.x, p.y, p.width, p.height]
        };
        assert_eq!(at(0), [0, 0, 0, 0, 8, 8]);
        assert_eq!(at(1), [0, 1, 6, 0, 8, 8]);
        assert_eq!(at(2), [0, 2, 12, 0, 3, 8]);
        assert_eq!(at(5), [1, 2, 12, 6, 3, 3]);
        assert_eq!(layout.order, [0, 1, 2, 3, 4, 5]);
        assert_eq!(layout.waves, [vec![0], vec![1], vec![2, 3], vec![4], vec![5]]);
        let small = Layout::new(&params(8, 2, false), (1, 8)).expect("layout");
        assert_eq!(small.placements, [Placement { row: 0, col: 0, x: 0, y: 0, width: 1, height: 8 }]);
    }

    #[test]
    fn tileable_layout_by_hand() {
        // 20 px in steps of at most 6: four columns of 5. 11 px: two rows, of 5 and 6. Each reaches 2 px further.
        let layout = Layout::new(&params(8, 2, true), (20, 11)).expect("layout");
        assert_eq!((layout.columns, layout.rows), (4, 2));
        let last = layout.placements[7];
        assert_eq!([last.row, last.col, last.x, last.y, last.width, last.height], [1, 3, 15, 5, 7, 8]);
        assert_eq!(layout.placements[0].height, 7);
        // By col + 2 row, upper row first: (0,0) (0,1) (0,2) (1,0) (0,3) (1,1) (1,2) (1,3).
        assert_eq!(layout.order, [0, 1, 2, 4, 3, 5, 6, 7]);
        assert_eq!(check_waves(&layout), Ok(()));
    }

    #[test]
    fn tileable_outputs_that_blocks_cannot_close_are_refused() {
        for (block, overlap, side) in [(8, 2, 3), (32, 6, 11), (8, 4, 9), (8, 4, 7)] {
            let params = params(block, overlap, true);
            let error = Layout::new(&params, (side, 64)).expect_err("too small");
            assert!(error.to_string().contains(&format!("at least {} px", 2 * overlap)), "{error}");
            assert!(params.validate((64, 64), (64, side)).is_err());
        }
        for (block, overlap, side) in [(8, 2, 4), (32, 6, 12), (8, 4, 8), (8, 4, 12)] {
            assert!(Layout::new(&params(block, overlap, true), (side, side)).is_ok(), "{block} {overlap} {side}");
        }
    }

    #[test]
    fn waves_follow_their_definition_for_all_shapes() {
        for (block, overlap) in [(4, 1), (4, 2), (5, 2), (8, 3)] {
            for (width, height) in [(1, 1), (3, 30), (30, 3), (9, 9), (17, 23), (32, 24), (24, 33)] {
                for tileable in [false, true] {
                    let Ok(layout) = Layout::new(&params(block, overlap, tileable), (width, height)) else {
                        assert!(tileable, "a plain layout exists for every size");
                        continue;
                    };
                    assert_eq!(check_waves(&layout), Ok(()), "{block} {overlap} {width}x{height} {tileable}");
                    let mut seen = vec![false; (width * height) as usize];
                    for index in 0..layout.columns * layout.rows {
                        for (x, y) in pixels(&layout, index) {
                            seen[(y * width + x) as usize] = true;
                        }
                    }
                    assert!(seen.iter().all(|&covered| covered), "every pixel lies in a block");
                    let by_formula = |b: u32| {
                        let (row, col) = (b / layout.columns, b % layout.columns);
                        (if layout.columns > 1 { col + 2 * row } else { row }) as usize
                    };
                    if !tileable {
                        assert!((0..).zip(&layout.waves).all(|(w, wave)| wave.iter().all(|&b| by_formula(b) == w)));
                    }
                }
            }
        }
    }

    #[test]
    fn the_wave_check_notices_a_block_moved_to_another_wave() {
        let good = Layout::new(&params(8, 2, false), (30, 30)).expect("layout");
        let mut early = good.clone();
        let moved = early.waves[3].remove(0);
        early.waves[2].push(moved);
        assert!(check_waves(&early).is_err());
        let mut late = good;
        let moved = late.waves[0].remove(0);
        late.waves.push(vec![moved]);
        assert!(check_waves(&late).is_err());
    }
}
