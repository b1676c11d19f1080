//! The oracle of repairs, on two blocks whose outcome can be told without it.

use impasto::synthesis::params::{BlockRecord, QuiltParams};
use impasto::synthesis::quilt_oracle::OracleGuide;
use impasto::synthesis::repair_oracle::{repair_oracle, BlockFate, CarriedTexture, OracleRepair, Repaired};

const OUTPUT: (u32, u32) = (14, 8);
const PIXELS: usize = 14 * 8;
const PARAMS: QuiltParams = QuiltParams { block_px: 8, overlap_px: 2, tolerance: 0.0, seed: 1, tileable: false };

/// Repairs two blocks of 8 px that overlap by 2, of a strip that grows redder by 10 a column. Its shade asks both for
/// the strip's left end; what was carried there is the strip as it is, but for what `change` does to it.
fn repair(slack_px: u32, change: impl Fn(&mut Vec<Option<CarriedTexture>>)) -> Repaired {
    let sample: Vec<[u8; 4]> = (0..20 * 8).map(|i| [10 * (i % 20) as u8, 0, 0, 255]).collect();
    let at_pixel = |i: usize| (64 * (i as u32 % 14), 64 * (i as u32 / 14));
    let mut carried = (0..PIXELS).map(|i| Some(CarriedTexture { place: at_pixel(i), misfit: false })).collect();
    change(&mut carried);
    let input = OracleRepair {
        sample: &sample,
        sample_size: (20, 8),
        output: OUTPUT,
        params: &PARAMS,
        guide: &OracleGuide { shade: &[0; PIXELS], covered: &[true; PIXELS], window_px: 0 },
        carried: &carried,
        slack_px,
        band_rows: u32::MAX,
    };
    repair_oracle(&input, 0).expect("a repair")
}

/// The second block, taken from the strip's left end; its overlap differs by 60 in 16 pixels, and of equal cuts the
/// left one is taken.
const PASTED: BlockFate = BlockFate::Pasted(BlockRecord {
    row: 0,
    col: 1,
    x: 6,
    y: 0,
    sx: 0,
    sy: 0,
    error: 16 * 60 * 60,
    min_error: 16 * 60 * 60,
    allowed: [0, 0, 0, 0],
});
const KEPT: BlockFate = BlockFate::Kept(0, 0);

#[test]
fn texture_from_too_far_away_is_synthesised_anew() {
    // The second block's left edge lies at column 6 of the strip, and ought to at 0.
    assert_eq!(repair(6, |_| ()).blocks, [KEPT, KEPT]);
    let repaired = repair(5, |_| ());
    assert_eq!(repaired.blocks, [KEPT, PASTED]);
    for (i, from) in repaired.source.iter().enumerate() {
        let (x, y) = (i as u16 % 14, i as u16 / 14);
        assert_eq!(*from, (x >= 6).then(|| (x - 6, y)), "pixel {x}, {y}");
    }
    // The mean of the cell, 7 by 8 pixels, must come down by a whole texel.
    let less = |steps: u32| {
        move |carried: &mut Vec<Option<CarriedTexture>>| {
            let columns = carried.iter_mut().enumerate().filter(|(i, _)| i % 14 >= 7);
            columns.filter_map(|(_, texture)| texture.as_mut()).for_each(|texture| texture.place.0 -= steps);
        }
    };
    assert_eq!(repair(5, less(64)).blocks, [KEPT, KEPT]);
    assert!(matches!(repair(5, less(63)).blocks[1], BlockFate::Pasted(_)));
}

#[test]
fn a_block_answers_for_its_cell() {
    // The middle of the overlap is column 7.
    let missing = |x: usize| move |carried: &mut Vec<Option<CarriedTexture>>| carried[x] = None;
    assert_eq!(repair(6, missing(7)).blocks[0], KEPT);
    assert!(matches!(repair(6, missing(7)).blocks[1], BlockFate::Pasted(_)));
    assert!(matches!(repair(6, missing(6)).blocks[0], BlockFate::Pasted(_)));
    assert_eq!(repair(6, missing(6)).blocks[1], KEPT);
}

#[test]
fn half_of_a_cell_may_be_misfit() {
    let misfits = |count: usize| {
        move |carried: &mut Vec<Option<CarriedTexture>>| {
            let cell = (0..PIXELS).filter(|i| i % 14 >= 7);
            cell.take(count).for_each(|i| carried[i].as_mut().expect("texture").misfit = true);
        }
    };
    assert_eq!(repair(6, misfits(28)).blocks, [KEPT, KEPT]);
    assert_eq!(repair(6, misfits(29)).blocks, [KEPT, PASTED]);
}

#[test]
fn wrong_numbers_of_pixels_are_refused() {
    let input = OracleRepair {
        sample: &[[0; 4]; 20 * 8],
        sample_size: (20, 8),
        output: OUTPUT,
        params: &PARAMS,
        guide: &OracleGuide { shade: &[0; PIXELS], covered: &[true; PIXELS], window_px: 0 },
        carried: &[None; PIXELS],
        slack_px: 0,
        band_rows: u32::MAX,
    };
    assert!(repair_oracle(&input, 0).is_ok());
    let refused = |input: OracleRepair| repair_oracle(&input, 0).expect_err("must be refused").to_string();
    assert!(refused(OracleRepair { sample: &[], ..input }).contains("sample is 0 pixels"));
    assert!(refused(OracleRepair { carried: &[None; 5], ..input }).contains("carried texture is 5 pixels"));
    let guide = OracleGuide { covered: &[], ..*input.guide };
    assert!(refused(OracleRepair { guide: &guide, ..input }).contains("guide covered is 0 pixels"));
}
