//! How much a pruned search has to do: what it bounds, and what it still compares.

use crate::Result;
use impasto::gpu::Runner;
use impasto::synthesis::params::{Placement, QuiltParams};
use impasto::synthesis::quilt::Quilt;

/// Positions side by side that are compared together, as in glsl/synthesis/quilt.glsl.
const TILE: u64 = 8;
/// As in glsl/synthesis/tile_bounds.glsl: what stands for a tile that was left out, tiles in a row of the image, and
/// what a block's tiles are rounded up to before that.
const NO_BOUND: [u8; 4] = [255; 4];
const BOUND_WORDS: u64 = 1024;
const GROUP: u64 = 128;

/// Of one quilting, free and not tileable.
#[derive(Default)]
pub struct Counts {
    /// At which a block is searched for.
    pub positions: u64,
    /// Of a position, by which a pruned search bounds its error.
    pub coordinates: u64,
    /// That have an overlap.
    pub blocks: u64,
    /// Of all blocks; whole ones, as both searches take them.
    pub tiles: u64,
    /// That were not left out. A pruned search compares some more: a few likely ones of each block first, which bound
    /// the least error, and which may turn out not to be among these.
    pub tiles_left: u64,
    /// Comparisons of two pixels at all tiles: what a full search does.
    pub comparisons: u64,
    /// The same at the tiles that were not left out.
    pub comparisons_left: u64,
}

impl Counts {
    /// What there is to do for a quilting of a sample `side` pixels wide and high; nothing is left of it.
    pub fn of_full_search(quilt: &Quilt, params: &QuiltParams, side: u32) -> Self {
        let columns = u64::from(side - params.block_px + 1);
        let tiles = columns.div_ceil(TILE) * columns;
        let mut counts = Counts { positions: columns * columns, ..Counts::default() };
        for placement in &quilt.layout().placements {
            let overlap = overlap_px(placement, params);
            if overlap > 0 {
                counts.blocks += 1;
                counts.tiles += tiles;
                counts.comparisons += TILE * tiles * overlap;
            }
        }
        counts
    }

    /// Quilts step by step, and looks after each search at what it has left; `None` if `quilt` does not prune.
    pub fn of_pruned_search(
        runner: &mut Runner,
        quilt: &Quilt,
        params: &QuiltParams,
        side: u32,
    ) -> Result<Option<Self>> {
        let Some(image) = quilt.tile_bounds() else { return Ok(None) };
        let mut counts = Counts::of_full_search(quilt, params, side);
        counts.coordinates = quilt.coordinates().unwrap_or_default().into();
        let layout = quilt.layout();
        let order: Vec<u32> = layout.waves.iter().flatten().copied().collect();
        let tiles = counts.tiles / counts.blocks.max(1);
        let row_words = tiles.next_multiple_of(GROUP).next_multiple_of(BOUND_WORDS);
        let (mut placed, mut bounds) = (0, Vec::new());
        for part in quilt.parts(1) {
            runner.run(|recorder| {
                quilt.record_part(recorder, part, 1, 0);
                Ok(())
            })?;
            let now = quilt.read_records(runner)?.len();
            if now == placed {
                bounds = runner.read_image(image)?;
            }
            // The step has placed the blocks that the one before it has searched for.
            for (slot, &index) in (0..).zip(&order[placed..now]) {
                let overlap = overlap_px(&layout.placements[index as usize], params);
                let words = &bounds[(4 * row_words * slot) as usize..][..4 * tiles as usize];
                let left = words.chunks_exact(4).filter(|word| *word != NO_BOUND).count() as u64;
                if overlap > 0 {
                    counts.tiles_left += left;
                    counts.comparisons_left += TILE * left * overlap;
                }
            }
            placed = now;
        }
        if placed != order.len() {
            return Err(format!("{placed} of {} blocks were placed", order.len()).into());
        }
        Ok(Some(counts))
    }

    /// Operations of `quilt_bound`: a multiply-add for each coordinate.
    pub fn bound_operations(&self) -> f64 {
        (2 * self.positions * self.blocks * self.coordinates) as f64
    }

    pub fn print(&self) {
        let share = |part: u64, all: u64| 100.0 * part as f64 / all.max(1) as f64;
        println!(
            "  bounds: {} positions x {} blocks x {} coordinates = {:.3} G multiply-adds",
            self.positions,
            self.blocks,
            self.coordinates,
            self.bound_operations() / 2e9
        );
        println!(
            "  tiles compared exactly: {} of {} ({:.3} %); pixel comparisons: {:.4} of {:.3} G, {:.3} % avoided",
            self.tiles_left,
            self.tiles,
            share(self.tiles_left, self.tiles),
            self.comparisons_left as f64 / 1e9,
            self.comparisons as f64 / 1e9,
            100.0 - share(self.comparisons_left, self.comparisons)
        );
    }
}

/// Pixels of a block along which it is compared: those of its left and upper overlaps.
fn overlap_px(placement: &Placement, params: &QuiltParams) -> u64 {
    let (width, height) = (u64::from(placement.width), u64::from(placement.height));
    let overlap = u64::from(params.overlap_px);
    let above = if placement.row > 0 { overlap.min(height) } else { 0 };
    let beside = if placement.col > 0 { overlap.min(width) } else { 0 };
    above * width + beside * (height - above)
}
