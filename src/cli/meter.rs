//! What every command that measures shares: the flags, which pixels are tested, and the search for their nearest.

use super::error_map::ErrorMap;
use super::failure::{Failure, Result};
use super::session::{Device, Session};
use super::table::{Cell, Table};
use clap::{Args, ValueEnum};
use impasto::metric::{
    check_block, choose, cooccurrence_error, sliced_wasserstein, BlockSearch, CooccurrenceParams, Eligible, Features,
    Neighbour, Picture, Score, Source, WassersteinParams,
};
use serde_json::{json, Map, Value};

/// Cells along the longer side of a map.
const MAP_CELLS: u32 = 64;

/// Flags of every command that measures.
#[derive(Args, Debug, Clone)]
pub struct MeterFlags {
    /// Side of the blocks that are compared, 4 to 12 pixels
    #[arg(long, value_name = "PX", default_value_t = 8, value_parser = clap::value_parser!(u32).range(4..=12),
          allow_negative_numbers = true, help_heading = "Measuring")]
    pub block_size: u32,
    /// How many of the nearest pixels of the strip are averaged, 1 to 32
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=32),
          allow_negative_numbers = true, help_heading = "Measuring")]
    pub nearest: u32,
    /// How many pixels are tested, at random among those whose block lies inside the object
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=1_000_000),
          allow_negative_numbers = true, help_heading = "Measuring")]
    pub samples: u32,
    /// Seed of that choice
    #[arg(long = "sample-seed", value_name = "N", default_value_t = 1, help_heading = "Measuring")]
    pub sample_seed: u32,
    /// How the nearest are found
    #[arg(long, value_enum, default_value_t, help_heading = "Measuring")]
    pub search: SearchName,
}

/// Ways to find the nearest.
#[derive(ValueEnum, Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SearchName {
    /// Compare with all by the metric itself, on the GPU
    #[default]
    Exact,
    /// A k-d tree over the 150 numbers, as the thesis: near by their Euclidean distance
    Kdtree,
}

/// The flags at work on a device.
pub struct Meter {
    flags: MeterFlags,
    search: BlockSearch,
}

impl MeterFlags {
    /// Adds the flags to the report.
    pub fn report(&self, session: &mut Session) {
        session.parameter("block_size", self.block_size);
        session.parameter("nearest", self.nearest);
        session.parameter("samples", self.samples);
        session.parameter("sample_seed", self.sample_seed);
        session.parameter("search", format!("{:?}", self.search).to_lowercase());
    }

    /// Some of the pixels that may be measured in `frame` and that `also` accepts.
    pub fn pixels(&self, frame: &Picture, also: impl Fn(u32, u32) -> bool) -> Result<Vec<(u32, u32)>> {
        check_block(self.block_size, frame)?;
        let all = Eligible::new(frame, self.block_size).all(also);
        if all.is_empty() {
            let block = self.block_size;
            return Err(Failure::new(format!(
                "there is nothing to measure: no block of {block} x {block} pixels lies inside the object"
            )));
        }
        Ok(choose(all, self.samples as usize, self.sample_seed))
    }
}

impl Meter {
    /// Makes ready to measure.
    pub fn new(flags: &MeterFlags, device: &Device) -> Result<Self> {
        let search = BlockSearch::new(&device.context, flags.nearest)?;
        Ok(Meter { flags: flags.clone(), search })
    }

    /// Prepares a strip to be searched.
    pub fn source(&self, device: &mut Device, strip: &Picture) -> Result<Source> {
        Ok(self.search.source(&mut device.runner, strip, self.flags.block_size)?)
    }

    /// The features of a frame's pixels.
    pub fn features(&self, device: &mut Device, frame: &Picture, pixels: &[(u32, u32)]) -> Result<Vec<Features>> {
        Ok(self.search.features(&mut device.runner, frame, self.flags.block_size, pixels)?)
    }

    /// The source pixels that are nearest to a frame's pixels.
    pub fn nearest(
        &self,
        session: &Session,
        device: &mut Device,
        source: &Source,
        frame: &Picture,
        pixels: &[(u32, u32)],
    ) -> Result<Vec<Vec<Neighbour>>> {
        let tested = self.features(device, frame, pixels)?;
        let mut found = Vec::with_capacity(tested.len());
        let progress = session.progress("searching", tested.len().div_ceil(TOGETHER));
        for tested in tested.chunks(TOGETHER) {
            found.extend(self.search.nearest(&mut device.runner, source, tested)?);
            progress.step();
        }
        Ok(found)
    }
}

/// Pixels between two steps of the progress bar.
const TOGETHER: usize = 256;

/// The pixels of a map: every so many pixels, so that the longer side has [`MAP_CELLS`] cells or as many as `step` says.
pub struct Grid {
    step: u32,
    width: u32,
    height: u32,
    pixels: Vec<(u32, u32)>,
}

impl Grid {
    /// The grid over a frame, without the pixels that may not be measured or that `also` refuses.
    pub fn new(frame: &Picture, block_px: u32, step: Option<u32>, also: impl Fn(u32, u32) -> bool) -> Self {
        let step = step.unwrap_or_else(|| frame.width().max(frame.height()).div_ceil(MAP_CELLS)).max(1);
        let eligible = Eligible::new(frame, block_px);
        let (width, height) = (frame.width().div_ceil(step), frame.height().div_ceil(step));
        let cells = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        // The pixel in the middle of each cell.
        let pixels = cells.map(|(x, y)| (x * step + step / 2, y * step + step / 2));
        let pixels = pixels.filter(|&(x, y)| eligible.contains(x, y) && also(x, y)).collect();
        Grid { step, width, height, pixels }
    }

    /// The pixels to measure.
    pub fn pixels(&self) -> &[(u32, u32)] {
        &self.pixels
    }

    /// The map of what was measured at them.
    pub fn map(&self, values: &[f64]) -> Result<ErrorMap> {
        let mut cells = vec![None; (self.width * self.height) as usize];
        for (&(x, y), value) in self.pixels.iter().zip(values) {
            cells[(y / self.step * self.width + x / self.step) as usize] = Some(*value as f32);
        }
        ErrorMap::new(self.width, self.height, cells)
    }
}

/// Figures under their names, for the terminal, JSON and CSV.
#[derive(Default)]
pub struct Figures(Vec<(String, Figure)>);

enum Figure {
    Score(Score),
    Number(f64),
}

impl Figures {
    /// Adds a mean with its interval.
    pub fn score(&mut self, name: &str, values: &[f64]) {
        if let Some(score) = Score::of(values) {
            self.0.push((name.to_owned(), Figure::Score(score)));
        }
    }

    /// Adds a single number.
    pub fn number(&mut self, name: &str, value: f64) {
        self.0.push((name.to_owned(), Figure::Number(value)));
    }

    /// The mean, or the number, of that name.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.0.iter().find(|(known, _)| known == name).map(|(_, figure)| match figure {
            Figure::Score(score) => score.mean,
            Figure::Number(number) => *number,
        })
    }

    /// Half the width of the confidence interval of that name.
    pub fn half_width(&self, name: &str) -> Option<f64> {
        self.0.iter().find(|(known, _)| known == name).and_then(|(_, figure)| match figure {
            Figure::Score(score) => score.half_width,
            Figure::Number(_) => None,
        })
    }

    /// The newer measures of a texture against its sample.
    pub fn textures(&mut self, sample: &Picture, frame: &Picture) -> Result {
        self.number("cooccurrence_error", cooccurrence_error(sample, frame, &CooccurrenceParams::default())?);
        self.number("sliced_wasserstein", sliced_wasserstein(sample, frame, &WassersteinParams::default())?);
        Ok(())
    }

    /// All of them as JSON.
    pub fn json(&self) -> Value {
        let value = |figure: &Figure| match figure {
            Figure::Score(Score { mean, half_width, count }) => {
                json!({ "mean": mean, "half_width_95": half_width, "count": count })
            }
            Figure::Number(number) => json!(number),
        };
        Value::Object(self.0.iter().map(|(name, figure)| (name.clone(), value(figure))).collect::<Map<_, _>>())
    }

    /// Their rows in a table of [`FIGURE_HEADERS`].
    pub fn rows(&self, table: &mut Table) {
        self.rows_after(table, &[]);
    }

    /// The same with cells before them in every row.
    pub fn rows_after(&self, table: &mut Table, before: &[&str]) {
        for (name, figure) in &self.0 {
            let mut cells: Vec<Cell> = before.iter().map(|text| Cell::from(*text)).collect();
            cells.push(name.replace('_', " ").into());
            match figure {
                Figure::Score(score) => cells.extend([
                    Cell::Number(score.mean, 5),
                    score.half_width.map_or(Cell::Missing, |half| Cell::Number(half, 5)),
                    Cell::Number(score.count as f64, 0),
                ]),
                Figure::Number(number) => cells.push(Cell::Number(*number, 5)),
            }
            table.row(cells);
        }
    }
}

/// The columns that [`Figures::rows`] fills.
pub const FIGURE_HEADERS: [&str; 4] = ["measure", "mean", "+- (95 %)", "pixels"];
