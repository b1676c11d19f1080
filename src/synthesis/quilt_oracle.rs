//! Image quilting on the CPU, as plainly as it can be said: the yardstick for the GPU's search, choice, cut and paste.
//!
//! Block by block, in the [`Layout`]'s placing order: measure how well every allowed position of the sample fits what
//! is painted already, choose at random among those that fit nearly as well as the best, cut the overlaps where the
//! error along the cut is least, and paste. All in integers, so that there is exactly one right answer.
//!
//! Method: A. Efros and W. Freeman, "Image Quilting for Texture Synthesis and Transfer", SIGGRAPH 2001, and thesis
//! 3.2.2; the guide, which keeps each block near the part of the sample that has its shade, is from thesis chapter 6.

use crate::error::{Error, Result};
use crate::synthesis::params::{BlockRecord, Layout, Placement, QuiltParams};

/// A picture that steers the quilting: where to paint, and how bright (thesis chapter 6).
#[derive(Debug, Clone, Copy)]
pub struct OracleGuide<'a> {
    /// One shade per output pixel, row by row: 0 leads to the sample's left end, 255 to its right end.
    pub shade: &'a [u8],
    /// One flag per output pixel, row by row. A block without a covered pixel is skipped.
    pub covered: &'a [bool],
    /// How far a block's left edge in the sample may be from where its mean shade points, in pixels.
    pub window_px: u32,
}

impl OracleGuide<'_> {
    /// Refuses a guide that is not of the output's size.
    pub(super) fn expect(&self, output: (u32, u32)) -> Result<()> {
        expect_pixels("guide shade", self.shade.len(), output)?;
        expect_pixels("guide covered", self.covered.len(), output)
    }

    /// The first and last left edge in the sample that the block may have; none where none of its pixels is covered.
    pub(super) fn window(
        &self,
        canvas: &Canvas,
        placement: &Placement,
        sample_width: u32,
        block_px: u32,
    ) -> Option<(u32, u32)> {
        let pixels = offsets(placement).map(|(dx, dy)| canvas.index(placement, dx, dy));
        let shades: Vec<u32> = pixels.filter(|&p| self.covered[p]).map(|p| u32::from(self.shade[p])).collect();
        guided_window(shades.iter().sum(), shades.len() as u32, sample_width, block_px, self.window_px)
    }
}

/// A quilted picture, and where all of it came from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Quilted {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// RGBA, row by row: alpha is 255 where painted; all four are 0 elsewhere.
    pub pixels: Vec<[u8; 4]>,
    /// The sample pixel (x, y) that each painted pixel is a copy of, row by row.
    pub source: Vec<Option<(u16, u16)>>,
    /// One record per placed block, in placing order.
    pub blocks: Vec<BlockRecord>,
}

/// Quilts an output of `output` = (width, height) pixels from `sample`, RGBA pixels row by row (alpha is ignored).
///
/// # Errors
/// [`Error::Parameter`] when a parameter or a size is out of range (see [`QuiltParams::validate`]), or when the sample
/// or the guide holds another number of pixels than its size says.
pub fn quilt_oracle(
    sample: &[[u8; 4]],
    sample_size: (u32, u32),
    output: (u32, u32),
    params: &QuiltParams,
    guide: Option<&OracleGuide>,
) -> Result<Quilted> {
    quilt(sample, sample_size, output, params, guide, 0, None)
}

/// The picture that a quilting is to match besides its own overlaps (thesis chapter 6).
#[derive(Debug, Clone, Copy)]
pub struct OraclePrevious<'a> {
    /// RGBA, row by row, of the output's size; a pixel counts where its alpha is 255.
    pub pixels: &'a [[u8; 4]],
    /// How much a pixel of it counts where a pixel of the overlap counts [`OVERLAP_WEIGHT`].
    pub weight: u32,
}

impl OraclePrevious<'_> {
    /// The colours where the block goes, row by row.
    fn colours(&self, canvas: &Canvas, placement: &Placement) -> Vec<Option<[u8; 3]>> {
        let at = |(dx, dy)| self.pixels[canvas.index(placement, dx, dy)];
        offsets(placement).map(at).map(|[r, g, b, a]| (a == 255).then_some([r, g, b])).collect()
    }
}

/// What a pixel of the overlap counts beside a previous picture.
pub const OVERLAP_WEIGHT: u32 = 4;

/// As [`quilt_oracle`], for a frame of a sequence in which each block is also to match the previous picture: its error
/// is [`OVERLAP_WEIGHT`] times that of the overlap, and the weight times that of all of the block's pixels against that
/// picture.
///
/// # Errors
/// [`Error::Parameter`] as [`quilt_oracle`], and for a previous picture that is not of the output's size.
pub fn quilt_oracle_after(
    sample: &[[u8; 4]],
    sample_size: (u32, u32),
    output: (u32, u32),
    params: &QuiltParams,
    guide: &OracleGuide,
    frame: u32,
    previous: &OraclePrevious,
) -> Result<Quilted> {
    expect_pixels("previous picture", previous.pixels.len(), output)?;
    quilt(sample, sample_size, output, params, Some(guide), frame, Some(previous))
}

fn quilt(
    sample: &[[u8; 4]],
    sample_size: (u32, u32),
    output: (u32, u32),
    params: &QuiltParams,
    guide: Option<&OracleGuide>,
    frame: u32,
    previous: Option<&OraclePrevious>,
) -> Result<Quilted> {
    params.validate(sample_size, output)?;
    expect_pixels("sample", sample.len(), sample_size)?;
    if let Some(guide) = guide {
        guide.expect(output)?;
    }
    let layout = Layout::new(params, output)?;
    let sample = Sample { pixels: sample, size: sample_size };
    let mut blocks = Vec::new();
    let canvas = place_blocks(&sample, &layout, params, |canvas, placement, index| {
        let (sx0, sx1) = match guide {
            None => (0, sample_size.0 - params.block_px),
            Some(guide) => guide.window(canvas, placement, sample_size.0, params.block_px)?,
        };
        let allowed = [sx0, 0, sx1, sample_size.1 - params.block_px];
        let old = canvas.colours(placement, &sample);
        let before = previous.map(|previous| previous.colours(canvas, placement));
        let error = |at| match (&before, previous) {
            (Some(before), Some(previous)) => {
                let (overlap, whole) = (sample.error(&old, placement, at), sample.error(before, placement, at));
                OVERLAP_WEIGHT * overlap + previous.weight * whole
            }
            _ => sample.error(&old, placement, at),
        };
        let hash = block_hash(params.seed, index, frame);
        let choice = choose(positions(allowed, 0, 1), error, params.tolerance_e4(), hash);
        blocks.push(choice.record(placement, allowed));
        Some((choice.sx, choice.sy))
    });

    let pixels = canvas.source.iter().map(|source| match source {
        Some((x, y)) => {
            let [r, g, b] = sample.rgb(u32::from(*x), u32::from(*y));
            [r, g, b, 255]
        }
        None => [0; 4],
    });
    Ok(Quilted { width: output.0, height: output.1, pixels: pixels.collect(), source: canvas.source, blocks })
}

/// As [`quilt_oracle`], but how well a position fits does not matter: each block is taken at random, all positions
/// alike, from those that `allowed` names for it, `[sx0, sy0, sx1, sy1]` with both ends. Only the cuts look at colours.
/// This is how the thesis makes pictures of poor texture (section 9.1.3); [`QuiltParams::tolerance`] means nothing
/// here.
///
/// Gives the sample pixel (x, y) that each pixel of the output is a copy of, row by row.
///
/// # Errors
/// [`Error::Parameter`] as [`quilt_oracle`], and for positions at which a block would not lie inside of the sample.
pub fn quilt_at_random(
    sample: &[[u8; 4]],
    sample_size: (u32, u32),
    output: (u32, u32),
    params: &QuiltParams,
    allowed: impl Fn(&Placement) -> [u32; 4],
) -> Result<Vec<(u16, u16)>> {
    params.validate(sample_size, output)?;
    expect_pixels("sample", sample.len(), sample_size)?;
    let layout = Layout::new(params, output)?;
    let last = [sample_size.0 - params.block_px, sample_size.1 - params.block_px];
    for [sx0, sy0, sx1, sy1] in layout.placements.iter().map(&allowed) {
        if sx0 > sx1 || sx1 > last[0] || sy0 > sy1 || sy1 > last[1] {
            let value = format!("{sx0}, {sy0} to {sx1}, {sy1}");
            return Err(Error::parameter("allowed", value, format!("within 0, 0 to {}, {}", last[0], last[1])));
        }
    }
    let sample = Sample { pixels: sample, size: sample_size };
    let canvas = place_blocks(&sample, &layout, params, |_, placement, index| {
        let [sx0, sy0, sx1, sy1] = allowed(placement);
        let columns = sx1 - sx0 + 1;
        let choice = choice_index(block_hash(params.seed, index, 0), columns * (sy1 - sy0 + 1));
        Some((sx0 + choice % columns, sy0 + choice / columns))
    });
    // Every block was placed, and the blocks cover the output.
    Ok(canvas.source.into_iter().flatten().collect())
}

/// Cuts and pastes block by block, in placing order, each from the position of the sample that `choose` takes when it
/// has seen what is painted so far; none for a block that is to be skipped. It is also told the block's index.
fn place_blocks(
    sample: &Sample,
    layout: &Layout,
    params: &QuiltParams,
    mut choose: impl FnMut(&Canvas, &Placement, u32) -> Option<(u32, u32)>,
) -> Canvas {
    let size = layout.output;
    let mut canvas = Canvas { size, source: vec![None; size.0 as usize * size.1 as usize] };
    let mut placed = vec![false; layout.placements.len()];
    for &index in &layout.order {
        let placement = &layout.placements[index as usize];
        let Some(position) = choose(&canvas, placement, index) else { continue };
        let old = canvas.colours(placement, sample);
        let active = active_sides(layout, placement, params.tileable, &placed);
        for ((dx, dy), from) in pasted(sample, &old, placement, params.overlap_px, &active, position) {
            let at = canvas.index(placement, dx, dy);
            canvas.source[at] = Some(from);
        }
        placed[index as usize] = true;
    }
    canvas
}

/// What a block from `position` of the sample pastes once it is cut on its active sides: its pixels, and the sample
/// pixels that they become copies of. `old` holds what is painted under the block.
pub(super) fn pasted(
    sample: &Sample,
    old: &[Option<[u8; 3]>],
    placement: &Placement,
    overlap_px: u32,
    active: &[Side],
    (sx, sy): (u32, u32),
) -> Vec<((u32, u32), (u16, u16))> {
    let new = sample.block(sx, sy, placement);
    let keeps_old = old_side_of_cuts(old, &new, placement, overlap_px, active);
    let taken = offsets(placement).zip(old.iter().zip(keeps_old)).filter(|(_, (old, keeps))| old.is_none() || !keeps);
    taken.map(|((dx, dy), _)| ((dx, dy), ((sx + dx) as u16, (sy + dy) as u16))).collect()
}

/// Sum of squared RGB differences between what is painted where a block goes and the sample at position (`sx`, `sy`).
///
/// `old` holds the output's colours under the block, row by row, `width` pixels a row; what is not painted yet does not
/// count. `None` when the block there would not lie inside of the sample (`sample_size` = width, height in pixels).
pub fn overlap_error(
    sample: &[[u8; 4]],
    sample_size: (u32, u32),
    old: &[Option<[u8; 3]>],
    width: u32,
    (sx, sy): (u32, u32),
) -> Option<u32> {
    let (sample_width, width) = (sample_size.0 as usize, width as usize);
    if width == 0 || sx as usize + width > sample_width {
        return old.is_empty().then_some(0);
    }
    let mut error = 0_u32;
    let mut start = sy as usize * sample_width + sx as usize;
    for old_row in old.chunks(width) {
        let new_row = sample.get(start..start + width)?;
        for (old, new) in old_row.iter().zip(new_row) {
            if let Some(old) = old {
                error = error.saturating_add(squared_difference(*old, [new[0], new[1], new[2]]));
            }
        }
        start += sample_width;
    }
    Some(error)
}

/// Largest error that is still chosen: `min_error` and `tolerance_e4` ten-thousandths of it, rounded down.
pub fn threshold(min_error: u32, tolerance_e4: u32) -> u32 {
    let more = u64::from(min_error) * u64::from(tolerance_e4) / 10_000;
    u32::try_from(u64::from(min_error).saturating_add(more)).unwrap_or(u32::MAX)
}

/// 32 random bits for a block in a frame, from nothing but the counters themselves.
///
/// The mixing step adds the golden ratio's 0x9e3779b9, so that zeros do not stay zeros, and then applies `lowbias32`
/// (C. Wellons, "Prospecting for Hash Functions", 2018).
pub fn block_hash(seed: u32, block: u32, frame: u32) -> u32 {
    let mix = |x: u32| {
        let mut x = x.wrapping_add(0x9e37_79b9);
        x ^= x >> 16;
        x = x.wrapping_mul(0x7feb_352d);
        x ^= x >> 15;
        x = x.wrapping_mul(0x846c_a68b);
        x ^ (x >> 16)
    };
    mix(mix(mix(seed) ^ block) ^ frame)
}

/// Which of `count` admissible positions a hash picks: its fraction of the 32-bit range, scaled to `0..count`.
pub fn choice_index(hash: u32, count: u32) -> u32 {
    ((u64::from(hash) * u64::from(count)) >> 32) as u32
}

/// The first and last `sx` that a guide allows a block with `covered` covered pixels whose shades add up to
/// `shade_sum`.
///
/// The mean shade points to a column of the sample, and the block's left edge may be up to `window_px` away from it
/// (thesis chapter 6), as far as a block of `block_px` fits into the sample, which is `sample_width` pixels wide.
/// `None` when no pixel is covered.
pub fn guided_window(
    shade_sum: u32,
    covered: u32,
    sample_width: u32,
    block_px: u32,
    window_px: u32,
) -> Option<(u32, u32)> {
    let (sum, window) = (u64::from(shade_sum), u64::from(window_px));
    let last = u64::from(sample_width.saturating_sub(block_px));
    let aim = (sum * u64::from(sample_width)).checked_div(255 * u64::from(covered))?;
    let low = aim.saturating_sub(window).min(last);
    let high = (aim + window).min(last);
    Some((low as u32, high as u32))
}

/// The minimum error cut through a strip of `strip` columns: for each row, the column where the cut crosses it.
///
/// `errors` holds the strip's pixel errors row by row. From row to row the cut moves by at most one column. Of equally
/// good cuts it is the one furthest left in the last row, then in the row before, and so on. By dynamic programming
/// (Efros and Freeman, section 2.1; thesis 3.2.2). Empty when the strip is.
pub fn seam_cut(errors: &[u32], strip: u32) -> Vec<u32> {
    let strip = strip as usize;
    if strip == 0 {
        return Vec::new();
    }
    let mut least: Vec<Vec<u64>> = Vec::new();
    for row in errors.chunks_exact(strip) {
        let total = |j: usize| {
            let before = least.last().map_or(0, |above| above[lowest(above, j.saturating_sub(1)..(j + 2).min(strip))]);
            u64::from(row[j]) + before
        };
        let totals = (0..row.len()).map(total).collect();
        least.push(totals);
    }
    let mut cut = Vec::with_capacity(least.len());
    let mut reach = 0..strip;
    for row in least.iter().rev() {
        let j = lowest(row, reach);
        reach = j.saturating_sub(1)..(j + 2).min(strip);
        cut.push(j as u32);
    }
    cut.reverse();
    cut
}

/// The first index of the least value in a range that is not empty.
fn lowest(values: &[u64], mut range: std::ops::Range<usize>) -> usize {
    let first = range.start;
    range.next();
    range.fold(first, |best, j| if values[j] < values[best] { j } else { best })
}

/// The sample, checked to hold as many pixels as its size says.
pub(super) struct Sample<'a> {
    pub pixels: &'a [[u8; 4]],
    pub size: (u32, u32),
}

impl Sample<'_> {
    fn rgb(&self, x: u32, y: u32) -> [u8; 3] {
        let [r, g, b, _] = self.pixels[(y * self.size.0 + x) as usize];
        [r, g, b]
    }

    /// The block's colours, taken from position (`sx`, `sy`), row by row.
    pub(super) fn block(&self, sx: u32, sy: u32, placement: &Placement) -> Vec<[u8; 3]> {
        offsets(placement).map(|(dx, dy)| self.rgb(sx + dx, sy + dy)).collect()
    }

    /// The error of the block at an allowed position against colours under it.
    pub fn error(&self, under: &[Option<[u8; 3]>], placement: &Placement, at: (u32, u32)) -> u32 {
        let error = overlap_error(self.pixels, self.size, under, placement.width, at);
        error.expect("allowed positions keep the block inside of the sample")
    }
}

/// The output while it grows: for each painted pixel, the sample pixel it is a copy of.
pub(super) struct Canvas {
    pub size: (u32, u32),
    pub source: Vec<Option<(u16, u16)>>,
}

impl Canvas {
    /// Where the block's pixel (`dx`, `dy`) lies in the output. Only a tileable layout's blocks ever wrap round.
    pub fn index(&self, placement: &Placement, dx: u32, dy: u32) -> usize {
        let (x, y) = ((placement.x + dx) % self.size.0, (placement.y + dy) % self.size.1);
        (y * self.size.0 + x) as usize
    }

    /// The colours under the block, row by row.
    pub fn colours(&self, placement: &Placement, sample: &Sample) -> Vec<Option<[u8; 3]>> {
        let at = |(dx, dy)| self.source[self.index(placement, dx, dy)];
        offsets(placement).map(|pixel| at(pixel).map(|(x, y)| sample.rgb(u32::from(x), u32::from(y)))).collect()
    }
}

/// The block's pixels relative to its top left one, row by row.
pub(super) fn offsets(placement: &Placement) -> impl Iterator<Item = (u32, u32)> {
    let (width, height) = (placement.width, placement.height);
    (0..height).flat_map(move |dy| (0..width).map(move |dx| (dx, dy)))
}

fn squared_difference(a: [u8; 3], b: [u8; 3]) -> u32 {
    let channel = |i: usize| u32::from(a[i].abs_diff(b[i])).pow(2);
    channel(0) + channel(1) + channel(2)
}

pub(super) fn expect_pixels(name: &'static str, pixels: usize, (width, height): (u32, u32)) -> Result<()> {
    if pixels as u64 == u64::from(width) * u64::from(height) {
        return Ok(());
    }
    Err(Error::parameter(name, format!("{pixels} pixels"), format!("{width} x {height} pixels")))
}

/// Those of the allowed positions whose row is `first_row` or a multiple of `row_step` further, in raster order.
pub(super) fn positions(
    [sx0, sy0, sx1, sy1]: [u32; 4],
    first_row: u32,
    row_step: u32,
) -> impl Iterator<Item = (u32, u32)> {
    (sy0 + first_row..=sy1).step_by(row_step as usize).flat_map(move |sy| (sx0..=sx1).map(move |sx| (sx, sy)))
}

/// The position chosen for a block, its error, and the least error there was.
pub(super) struct Choice {
    pub sx: u32,
    pub sy: u32,
    error: u32,
    min_error: u32,
}

impl Choice {
    pub fn record(&self, placement: &Placement, allowed: [u32; 4]) -> BlockRecord {
        let Placement { row, col, x, y, .. } = *placement;
        let Choice { sx, sy, error, min_error } = *self;
        BlockRecord { row, col, x, y, sx, sy, error, min_error, allowed }
    }
}

/// Chooses among positions, of which there is at least one.
pub(super) fn choose(
    positions: impl Iterator<Item = (u32, u32)>,
    error: impl Fn((u32, u32)) -> u32,
    tolerance_e4: u32,
    hash: u32,
) -> Choice {
    let fits: Vec<(u32, u32, u32)> = positions.map(|at| (at.0, at.1, error(at))).collect();
    let min_error = fits.iter().map(|fit| fit.2).min().expect("at least one position is allowed");
    let limit = threshold(min_error, tolerance_e4);
    let admissible: Vec<_> = fits.into_iter().filter(|fit| fit.2 <= limit).collect();
    let (sx, sy, error) = admissible[choice_index(hash, admissible.len() as u32) as usize];
    Choice { sx, sy, error, min_error }
}

#[derive(Clone, Copy, PartialEq)]
pub(super) enum Side {
    Left,
    Right,
    Top,
    Bottom,
}

/// The sides on which the neighbouring block exists and has been placed: where the block must be cut.
pub(super) fn active_sides(layout: &Layout, placement: &Placement, tileable: bool, placed: &[bool]) -> Vec<Side> {
    let Placement { row, col, .. } = *placement;
    let (columns, rows) = (layout.columns, layout.rows);
    // The grid closes into a ring where the output is to tile, and ends at its borders elsewhere.
    let before = |at: u32, count: u32| if at > 0 { Some(at - 1) } else { tileable.then_some(count - 1) };
    let after = |at: u32, count: u32| if at + 1 < count { Some(at + 1) } else { tileable.then_some(0) };
    let neighbours = [
        (Side::Left, before(col, columns).map(|col| (row, col))),
        (Side::Right, after(col, columns).map(|col| (row, col))),
        (Side::Top, before(row, rows).map(|row| (row, col))),
        (Side::Bottom, after(row, rows).map(|row| (row, col))),
    ];
    let is_placed = |(row, col): (u32, u32)| placed[(row * columns + col) as usize];
    neighbours.into_iter().filter(|(_, at)| at.is_some_and(is_placed)).map(|(side, _)| side).collect()
}

/// For each of the block's pixels, row by row, whether a cut leaves it on the neighbour's side.
///
/// Each active side has a strip as wide as the overlap, with a cut along it. The pixels on the cut are the new block's.
fn old_side_of_cuts(
    old: &[Option<[u8; 3]>],
    new: &[[u8; 3]],
    placement: &Placement,
    overlap: u32,
    active: &[Side],
) -> Vec<bool> {
    let (width, height) = (placement.width, placement.height);
    let mut on_old_side = vec![false; new.len()];
    for &side in active {
        let (length, strip) = match side {
            Side::Left | Side::Right => (height, overlap.min(width)),
            Side::Top | Side::Bottom => (width, overlap.min(height)),
        };
        // The block's pixel at step `i` along the strip and `j` across it.
        let pixel = |i: u32, j: u32| {
            let (x, y) = match side {
                Side::Left => (j, i),
                Side::Right => (width - strip + j, i),
                Side::Top => (i, j),
                Side::Bottom => (i, height - strip + j),
            };
            (y * width + x) as usize
        };
        let across = |i: u32| (0..strip).map(move |j| (i, j));
        let error = |(i, j)| old[pixel(i, j)].map_or(0, |old| squared_difference(old, new[pixel(i, j)]));
        let errors: Vec<u32> = (0..length).flat_map(across).map(error).collect();
        let cut = seam_cut(&errors, strip);
        for (i, j) in (0..length).flat_map(across) {
            let crossing = cut[i as usize];
            let beyond = if matches!(side, Side::Left | Side::Top) { j < crossing } else { j > crossing };
            on_old_side[pixel(i, j)] |= beyond;
        }
    }
    on_old_side
}
