//! A second telling of image quilting, which judges a finished quilt: block by block it works out from the sample what
//! the records and pixels have to be, in other words and with other data structures than the oracle.

use std::collections::{HashMap, HashSet};

use impasto::synthesis::params::QuiltParams;
use impasto::synthesis::quilt_oracle::{quilt_oracle, OracleGuide, Quilted};

/// Everything that goes into a quilting.
#[derive(Clone, Copy)]
pub struct Case<'a> {
    pub sample: &'a [[u8; 4]],
    pub size: (u32, u32),
    pub output: (u32, u32),
    pub params: QuiltParams,
    pub guide: Option<OracleGuide<'a>>,
}

impl Case<'_> {
    pub fn quilt(&self) -> Quilted {
        quilt_oracle(self.sample, self.size, self.output, &self.params, self.guide.as_ref()).expect("a valid case")
    }

    fn rgb(&self, (x, y): (i64, i64)) -> [i64; 3] {
        let [r, g, b, _] = self.sample[(y * i64::from(self.size.0) + x) as usize];
        [r.into(), g.into(), b.into()]
    }
}

/// A cell (column, row) of the grid of blocks.
type Cell = (i64, i64);
/// A pixel (x, y) of the output or of the sample.
type Pixel = (i64, i64);

/// The start and length of every column, or of every row.
fn spans(params: &QuiltParams, side: i64) -> Vec<(i64, i64)> {
    let (block, overlap) = (i64::from(params.block_px), i64::from(params.overlap_px));
    let step = block - overlap;
    if params.tileable {
        let count = ((side as f64 / step as f64).ceil() as i64).max(2);
        let starts: Vec<i64> = (0..=count).map(|c| (c * side).div_euclid(count)).collect();
        return starts.windows(2).map(|pair| (pair[0], pair[1] - pair[0] + overlap)).collect();
    }
    // Add blocks until one reaches the end.
    let mut spans = vec![(0, block.min(side))];
    while let Some(&(start, _)) = spans.last().filter(|(start, _)| start + block < side) {
        spans.push((start + step, block.min(side - start - step)));
    }
    spans
}

/// The 32-bit hash, on wide integers and without shifts or exclusive ors.
pub fn hash(seed: u32, block: u32, frame: u32) -> u64 {
    const RANGE: u64 = 1 << 32;
    let xor = |a: u64, b: u64| a + b - 2 * (a & b);
    let mix = |x: u64| {
        let x = (x + 2_654_435_769) % RANGE;
        let x = xor(x, x / 65_536) * 2_146_121_005 % RANGE;
        let x = xor(x, x / 32_768) * 2_221_713_035 % RANGE;
        xor(x, x / 65_536)
    };
    mix(xor(mix(xor(mix(seed.into()), block.into())), frame.into()))
}

/// The cheapest path down a table: of all (total, columns from the last row upwards), the least.
fn cheapest_path(table: &[Vec<i64>]) -> Vec<i64> {
    let mut best: Vec<(i64, Vec<i64>)> = table[0].iter().enumerate().map(|(j, e)| (*e, vec![j as i64])).collect();
    for row in &table[1..] {
        let extend = |(j, e): (usize, &i64)| {
            let near = best.iter().enumerate().filter(|(k, _)| k.abs_diff(j) <= 1).map(|(_, path)| path);
            let (total, path) = near.min().expect("the column above");
            (total + e, [vec![j as i64], path.clone()].concat())
        };
        best = row.iter().enumerate().map(extend).collect();
    }
    let (_, upwards) = best.into_iter().min().expect("a column");
    upwards.into_iter().rev().collect()
}

fn distance(a: [i64; 3], b: [i64; 3]) -> i64 {
    (0..3).map(|i| (a[i] - b[i]) * (a[i] - b[i])).sum()
}

fn same<T: PartialEq + std::fmt::Debug>(what: &str, cell: Cell, found: T, expected: T) -> Result<(), String> {
    if found == expected {
        return Ok(());
    }
    Err(format!("{what} of the block at (column, row) {cell:?}: {found:?} instead of {expected:?}"))
}

/// Says what is wrong with a quilt, its records or its pixels.
pub fn check(case: &Case, result: &Quilted) -> Result<(), String> {
    let (params, (w, h)) = (&case.params, (i64::from(case.output.0), i64::from(case.output.1)));
    let (block, overlap) = (i64::from(params.block_px), i64::from(params.overlap_px));
    let (across, down) = (spans(params, w), spans(params, h));
    let (columns, rows) = (across.len() as i64, down.len() as i64);
    let mut cells: Vec<Cell> = (0..rows).flat_map(|row| (0..columns).map(move |col| (col, row))).collect();
    if params.tileable {
        cells.sort_by_key(|&(col, row)| (col + 2 * row, row));
    }

    let mut painted: HashMap<Pixel, Pixel> = HashMap::new();
    let mut placed: HashSet<Cell> = HashSet::new();
    let mut records = result.blocks.iter();
    for cell @ (col, row) in cells {
        let ((x, width), (y, height)) = (across[col as usize], down[row as usize]);
        let locals: Vec<Pixel> = (0..height).flat_map(|dy| (0..width).map(move |dx| (dx, dy))).collect();
        let target = |(dx, dy): Pixel| ((x + dx) % w, (y + dy) % h);

        let (mut first, last) = (0, i64::from(case.size.0) - block);
        let mut end = last;
        if let Some(guide) = &case.guide {
            let at = |local| target(local).1 as usize * w as usize + target(local).0 as usize;
            let covered = locals.iter().map(|&local| at(local)).filter(|&at| guide.covered[at]);
            let shades: Vec<i64> = covered.map(|at| guide.shade[at].into()).collect();
            if shades.is_empty() {
                continue;
            }
            let aim = shades.iter().sum::<i64>() * i64::from(case.size.0) / (255 * shades.len() as i64);
            first = (aim - i64::from(guide.window_px)).clamp(0, last);
            end = (aim + i64::from(guide.window_px)).clamp(0, last);
        }
        let bottom = i64::from(case.size.1) - block;
        let record = records.next().ok_or(format!("no record for the block at {cell:?}"))?;
        same("cell", cell, (i64::from(record.col), i64::from(record.row)), cell)?;
        same("corner", cell, (i64::from(record.x), i64::from(record.y)), (x, y))?;
        same("allowed", cell, record.allowed.map(i64::from), [first, 0, end, bottom])?;

        let old: HashMap<Pixel, [i64; 3]> =
            locals.iter().filter_map(|&local| Some((local, case.rgb(*painted.get(&target(local))?)))).collect();
        let error_at = |(sx, sy): Pixel| -> i64 {
            old.iter().map(|(&(dx, dy), &colour)| distance(colour, case.rgb((sx + dx, sy + dy)))).sum()
        };
        let allowed: Vec<Pixel> = (0..=bottom).flat_map(|sy| (first..=end).map(move |sx| (sx, sy))).collect();
        let errors: Vec<i64> = allowed.iter().map(|&position| error_at(position)).collect();
        let least = *errors.iter().min().ok_or("nothing is allowed")?;
        same("least error", cell, i64::from(record.min_error), least)?;
        let most = least as f64 * (1.0 + f64::from(params.tolerance_e4()) / 10_000.0) + 1e-6;
        let fitting: Vec<usize> = (0..allowed.len()).filter(|&i| errors[i] as f64 <= most).collect();
        let fraction = hash(params.seed, (row * columns + col) as u32, 0) as f64 / 4_294_967_296.0;
        let choice = fitting[(fraction * fitting.len() as f64) as usize];
        let (sx, sy) = allowed[choice];
        same("position", cell, (i64::from(record.sx), i64::from(record.sy)), (sx, sy))?;
        same("error", cell, i64::from(record.error), errors[choice])?;

        // Neighbour, and how a step along and a step across its strip lead to a pixel of the block.
        type Walk<'a> = Box<dyn Fn(i64, i64) -> Pixel + 'a>;
        let sides: [(Cell, i64, bool, Walk); 4] = [
            ((col - 1, row), height, true, Box::new(|i, j| (j, i))),
            ((col + 1, row), height, false, Box::new(move |i, j| (width - overlap + j, i))),
            ((col, row - 1), width, true, Box::new(|i, j| (i, j))),
            ((col, row + 1), width, false, Box::new(move |i, j| (i, height - overlap + j))),
        ];
        let mut kept: HashSet<Pixel> = HashSet::new();
        for ((beside, above), length, old_comes_first, walk) in sides {
            let ring = (beside.rem_euclid(columns), above.rem_euclid(rows));
            if !placed.contains(&ring) || (!params.tileable && ring != (beside, above)) {
                continue;
            }
            let cost = |pixel: Pixel| {
                old.get(&pixel).map_or(0, |&colour| distance(colour, case.rgb((sx + pixel.0, sy + pixel.1))))
            };
            let table: Vec<Vec<i64>> = (0..length).map(|i| (0..overlap).map(|j| cost(walk(i, j))).collect()).collect();
            for (i, crossing) in (0..).zip(cheapest_path(&table)) {
                let theirs = if old_comes_first { 0..crossing } else { crossing + 1..overlap };
                kept.extend(theirs.map(|j| walk(i, j)));
            }
        }
        for &local in locals.iter().filter(|local| !(kept.contains(local) && old.contains_key(local))) {
            painted.insert(target(local), (sx + local.0, sy + local.1));
        }
        placed.insert(cell);
    }
    if records.next().is_some() {
        return Err("a record of a block that is not placed".into());
    }
    for (at, (pixel, source)) in result.pixels.iter().zip(&result.source).enumerate() {
        let expected = painted.get(&(at as i64 % w, at as i64 / w)).copied();
        if source.map(|(x, y)| (i64::from(x), i64::from(y))) != expected {
            return Err(format!("source of pixel {at}: {source:?} instead of {expected:?}"));
        }
        let colour = expected.map_or([0; 4], |from| {
            let [r, g, b] = case.rgb(from);
            [r, g, b, 255]
        });
        if pixel.map(i64::from) != colour {
            return Err(format!("pixel {at}: {pixel:?} instead of {colour:?}"));
        }
    }
    let sizes = [result.pixels.len() as i64, result.source.len() as i64];
    same("pixel counts", (columns, rows), sizes, [w * h; 2])
}
