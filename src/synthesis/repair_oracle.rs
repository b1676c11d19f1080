//! Repairs on the CPU, as plainly as they can be said: the yardstick for the GPU's [`super::repair`].
//!
//! Block by block: does the texture that was carried into the block's cell stay? Then the blocks whose texture does not
//! are placed as in quilting, but between neighbours on all sides: against what stays, and against what was placed
//! before them. All in integers, so that there is exactly one right answer.
//!
//! Of the quilting's oracle it has the choice, the cut and the paste; with the GPU stages it shares
//! [`super::params`] alone.

use super::params::{BlockRecord, Layout, Placement, QuiltParams};
use super::quilt_oracle::{
    active_sides, block_hash, choose, expect_pixels, offsets, pasted, positions, Canvas, OracleGuide, Sample,
};
use crate::error::Result;

/// Steps of a texel in a place.
const STEPS: u32 = 64;

/// About how many positions a block is compared at.
const POSITIONS: u32 = 2048;

/// Texture that was carried to a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CarriedTexture {
    /// Where in the sample it comes from, x and y in 1/64 texels; the nearest texel must be one of the sample.
    pub place: (u32, u32),
    /// Whether it is stretched, compressed or turned so far that it no longer looks like the sample.
    pub misfit: bool,
}

/// What became of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BlockFate {
    /// None of its cell is covered.
    Skipped,
    /// Its texture stays. First and last column of the sample where its shade lets a block begin.
    Kept(u32, u32),
    /// It was synthesised anew.
    Pasted(BlockRecord),
}

/// A repaired quilting.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Repaired {
    /// The sample pixel (x, y) that each pixel which was synthesised anew is a copy of, row by row.
    pub source: Vec<Option<(u16, u16)>>,
    /// One for each block, row by row.
    pub blocks: Vec<BlockFate>,
}

/// What a repair starts from.
#[derive(Debug, Clone, Copy)]
pub struct OracleRepair<'a> {
    /// RGBA, row by row; alpha is ignored.
    pub sample: &'a [[u8; 4]],
    /// Width and height of the sample, pixels.
    pub sample_size: (u32, u32),
    /// Width and height of the output, pixels.
    pub output: (u32, u32),
    /// How it was quilted; not tileable. The seed enters the random choices.
    pub params: &'a QuiltParams,
    /// The guide as it is now.
    pub guide: &'a OracleGuide<'a>,
    /// What was carried to each covered pixel, row by row; none elsewhere.
    pub carried: &'a [Option<CarriedTexture>],
    /// How far outside of its window a block's texture may come from, texels.
    pub slack_px: u32,
    /// An even number of rows of blocks that are finished before those below begin; `u32::MAX` where memory is no
    /// matter.
    pub band_rows: u32,
}

/// Repairs a quilting. `frame` enters the random choices, and says which rows of positions are compared.
///
/// # Errors
/// [`crate::Error::Parameter`] when a parameter or a size is out of range (see [`QuiltParams::validate`]), or a picture
/// holds another number of pixels than its size says.
pub fn repair_oracle(input: &OracleRepair, frame: u32) -> Result<Repaired> {
    let OracleRepair { sample, sample_size, output, params, guide, carried, .. } = *input;
    params.validate(sample_size, output)?;
    expect_pixels("sample", sample.len(), sample_size)?;
    guide.expect(output)?;
    expect_pixels("carried texture", carried.len(), output)?;
    let layout = Layout::new(params, output)?;
    let sample = Sample { pixels: sample, size: sample_size };
    let mut canvas = Canvas { size: output, source: carried.iter().map(|texture| texture.map(nearest)).collect() };
    let windows: Vec<_> = layout
        .placements
        .iter()
        .map(|placement| guide.window(&canvas, placement, sample_size.0, params.block_px))
        .collect();
    let fate = |(placement, window): (&Placement, &Option<(u32, u32)>)| match window {
        Some(window) => fate_of_cell(input, &layout, placement, *window),
        None => Some(BlockFate::Skipped),
    };
    // None for what is yet to be placed.
    let mut fates: Vec<Option<BlockFate>> = layout.placements.iter().zip(&windows).map(fate).collect();
    let mut placed: Vec<bool> = fates.iter().map(|fate| matches!(fate, Some(BlockFate::Kept(..)))).collect();

    let mut source = vec![None; carried.len()];
    for index in rounds(&layout, input.band_rows) {
        let placement = &layout.placements[index];
        let (None, Some(window)) = (fates[index], windows[index]) else { continue };
        let mut old = canvas.colours(placement, &sample);
        for (colour, (dx, dy)) in old.iter_mut().zip(offsets(placement)) {
            if !lies_in_a_placed_field(&layout, params, placement, &placed, (dx, dy)) {
                *colour = None;
            }
        }
        let allowed = [window.0, 0, window.1, sample_size.1 - params.block_px];
        let (first_row, row_step) = compared_rows(input, frame);
        let error =
            |at| sample.error(&old, placement, at) + missing_contrast(&old, &sample.block(at.0, at.1, placement));
        let hash = block_hash(params.seed, index as u32, frame);
        let choice = choose(positions(allowed, first_row, row_step), error, params.tolerance_e4(), hash);
        let active = active_sides(&layout, placement, false, &placed);
        for ((dx, dy), from) in pasted(&sample, &old, placement, params.overlap_px, &active, (choice.sx, choice.sy)) {
            let at = canvas.index(placement, dx, dy);
            canvas.source[at] = Some(from);
            source[at] = Some(from);
        }
        fates[index] = Some(BlockFate::Pasted(choice.record(placement, allowed)));
        placed[index] = true;
    }
    Ok(Repaired { source, blocks: fates.into_iter().flatten().collect() })
}

/// The texel nearest to a place.
fn nearest(texture: CarriedTexture) -> (u16, u16) {
    let texel = |steps: u32| ((steps + STEPS / 2) / STEPS) as u16;
    (texel(texture.place.0), texel(texture.place.1))
}

/// Whether a block's texture stays, judged by its cell: what lies nearer to it than to its neighbours. None when it is
/// to be synthesised anew.
fn fate_of_cell(
    input: &OracleRepair,
    layout: &Layout,
    placement: &Placement,
    (first, last): (u32, u32),
) -> Option<BlockFate> {
    let QuiltParams { block_px, overlap_px, .. } = *input.params;
    // From the middle of the overlap with the block before to that with the block after, or to the output's border.
    let in_cell = |d: u32, at: u32, count: u32| {
        let after_begin = at == 0 || d >= overlap_px / 2;
        let before_end = at + 1 == count || d < block_px - overlap_px + overlap_px / 2;
        after_begin && before_end
    };
    let cell: Vec<(u32, usize)> = offsets(placement)
        .filter(|(dx, dy)| in_cell(*dx, placement.col, layout.columns) && in_cell(*dy, placement.row, layout.rows))
        .map(|(dx, dy)| (dx, ((placement.y + dy) * layout.output.0 + placement.x + dx) as usize))
        .filter(|(_, pixel)| input.guide.covered[*pixel])
        .collect();
    if cell.is_empty() {
        return Some(BlockFate::Skipped);
    }
    let textures: Option<Vec<CarriedTexture>> = cell.iter().map(|(_, pixel)| input.carried[*pixel]).collect();
    let textures = textures?;
    let misfits = textures.iter().filter(|texture| texture.misfit).count();
    // Where the block's left edge would lie in the sample, by each of its pixels, in steps.
    let edges = textures.iter().zip(&cell);
    let edge_sum: i64 = edges.map(|(texture, (dx, _))| i64::from(texture.place.0) - i64::from(STEPS * dx)).sum();
    // The mean is within the window if the sum is within so many times the window.
    let times = i64::from(STEPS) * cell.len() as i64;
    let slack = i64::from(input.slack_px);
    let in_window = (times * (i64::from(first) - slack)..=times * (i64::from(last) + slack)).contains(&edge_sum);
    (2 * misfits <= cell.len() && in_window).then_some(BlockFate::Kept(first, last))
}

/// The order of placing: bands of rows from the top; in each, the blocks of even rows and columns, those of even rows
/// and odd columns, those of odd rows and even columns, and the others.
fn rounds(layout: &Layout, band_rows: u32) -> Vec<usize> {
    let mut order: Vec<usize> = (0..layout.placements.len()).collect();
    order.sort_by_key(|&index| {
        let Placement { row, col, .. } = layout.placements[index];
        (row / band_rows, row % 2, col % 2)
    });
    order
}

/// The first of the rows of positions that are compared, and their distance.
fn compared_rows(input: &OracleRepair, frame: u32) -> (u32, u32) {
    let all = |side: u32| side - input.params.block_px + 1;
    let rows = all(input.sample_size.1);
    let columns = all(input.sample_size.0).min(input.guide.window_px.saturating_mul(2).saturating_add(1));
    let row_step = (rows * columns / POSITIONS).clamp(1, rows);
    (frame % row_step, row_step)
}

/// What a block lacks of the contrast of the colours under it, where there are any: by how much their squared
/// differences from the middle grey, 128, add up to more than its own.
fn missing_contrast(under: &[Option<[u8; 3]>], block: &[[u8; 3]]) -> u32 {
    let contrast = |color: [u8; 3]| color.map(|value| u32::from(value.abs_diff(128)).pow(2)).iter().sum::<u32>();
    let pairs = under.iter().zip(block).filter_map(|(under, own)| Some(((*under)?, *own)));
    let (around, own) = pairs.fold((0, 0), |(a, b), (under, own)| (a + contrast(under), b + contrast(own)));
    around.saturating_sub(own)
}

/// Whether any placed neighbour reaches to the block's pixel, by fields: overlaps cut a block into three by three of
/// them.
fn lies_in_a_placed_field(
    layout: &Layout,
    params: &QuiltParams,
    placement: &Placement,
    placed: &[bool],
    (dx, dy): (u32, u32),
) -> bool {
    // The neighbours along an axis that reach to a pixel: the block itself or one beside it.
    let reach = |d: u32| match d {
        _ if d < params.overlap_px => -1..=0,
        _ if d < params.block_px - params.overlap_px => 0..=0,
        _ => 0..=1,
    };
    let is_placed = |by_row: i32, by_col: i32| {
        let (row, col) = (placement.row.checked_add_signed(by_row), placement.col.checked_add_signed(by_col));
        let (Some(row), Some(col)) = (row.filter(|row| *row < layout.rows), col.filter(|col| *col < layout.columns))
        else {
            return false;
        };
        (by_row, by_col) != (0, 0) && placed[(row * layout.columns + col) as usize]
    };
    reach(dy).any(|by_row| reach(dx).any(|by_col| is_placed(by_row, by_col)))
}
