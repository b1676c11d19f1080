//! What every command that measures shares: the flags, which pixels are tested, the search for their nearest, and what
//! moves where.

use super::error_map::ErrorMap;
use super::failure::{Failure, Result};
use super::session::{Device, Session};
use super::table::{Cell, Table};
use super::values::Size;
use clap::{Args, ValueEnum};
use image::RgbaImage;
use impasto::metric::{
    choose, coherence, cooccurrence_error, sliced_wasserstein, BlockSearch, CooccurrenceParams, Eligible, Features,
    KdTree, Motion, Neighbour, Picture, Score, Source, WassersteinParams,
};
use impasto::paint::PaintSample;
use impasto::scene::{Guide, GuideOracle, Mesh, Moment};
use serde_json::{json, Map, Value};
use std::path::Path;

/// Cells along the longer side of a map.
const MAP_CELLS: u32 = 64;
/// Pixels between two steps of the progress bar.
const TOGETHER: usize = 256;

/// Which pixels are tested, and how large the blocks around them are.
#[derive(Args, Debug, Clone)]
pub struct TestFlags {
    /// Side of the blocks that are compared, 4 to 12 pixels
    #[arg(long, value_name = "PX", default_value_t = 8, value_parser = clap::value_parser!(u32).range(4..=12),
          allow_negative_numbers = true, help_heading = "Measuring")]
    pub block_size: u32,
    /// How many pixels are tested, 1 to 1,000,000, at random among those whose block lies inside the object
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=1_000_000),
          allow_negative_numbers = true, help_heading = "Measuring")]
    pub samples: u32,
    /// Seed of that choice
    #[arg(long = "sample-seed", value_name = "N", default_value_t = 1, help_heading = "Measuring")]
    pub sample_seed: u32,
}

/// How the nearest pixels of a strip are found.
#[derive(Args, Debug, Clone)]
pub struct SearchFlags {
    /// How many of the nearest pixels of the strip are averaged, 1 to 32
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=32),
          allow_negative_numbers = true, help_heading = "Measuring")]
    pub nearest: u32,
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

impl TestFlags {
    /// Adds the flags to the report.
    pub fn report(&self, session: &mut Session) {
        session.parameter("block_size", self.block_size);
        session.parameter("samples", self.samples);
        session.parameter("sample_seed", self.sample_seed);
    }

    /// Some of the pixels that may be measured in `frame` and that `also` accepts, which `reason` tells of when there
    /// are none.
    pub fn pixels(&self, frame: &Picture, reason: &str, also: impl Fn(u32, u32) -> bool) -> Result<Vec<(u32, u32)>> {
        let all = Eligible::new(frame, self.block_size).all(also);
        if all.is_empty() {
            let block = self.block_size;
            let text =
                format!("there is nothing to measure: no block of {block} x {block} pixels lies inside the object");
            return Err(Failure::new(format!("{text}{reason}")));
        }
        Ok(choose(all, self.samples as usize, self.sample_seed))
    }
}

impl SearchFlags {
    /// Adds the flags to the report.
    pub fn report(&self, session: &mut Session) {
        session.parameter("nearest", self.nearest);
        session.parameter("search", format!("{:?}", self.search).to_lowercase());
    }
}

/// Loads a sample of paint as painting sees it: on white paper.
pub fn load_sample(path: &Path) -> Result<Picture> {
    sample_picture(&PaintSample::load(path)?)
}

/// A sample of paint as a picture.
pub fn sample_picture(sample: &PaintSample) -> Result<Picture> {
    Ok(Picture::new(sample.width(), sample.height(), sample.to_rgba8())?)
}

/// A frame as a picture.
pub fn frame_picture(frame: &RgbaImage) -> Result<Picture> {
    Ok(Picture::new(frame.width(), frame.height(), frame.pixels().map(|pixel| pixel.0).collect())?)
}

/// The value that a share of the values, 0 to 1, is not above; of no value, nothing.
pub fn quantile(values: &[f64], share: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get((sorted.len().saturating_sub(1) as f64 * share).round() as usize).copied()
}

/// What a frame shows of the scene, for the motion to the next.
pub struct Seen {
    moment: Moment,
    guide: Guide,
}

impl Seen {
    /// Looks at the scene.
    pub fn new(mesh: &Mesh, moment: &Moment, size: Size) -> Result<Self> {
        let guide = GuideOracle::render(mesh, moment, size.width, size.height)?;
        Ok(Seen { moment: moment.clone(), guide })
    }

    /// The motion to the next frame.
    pub fn motion_to(&self, next: &Seen) -> Result<Motion> {
        Ok(Motion::between([&self.moment, &next.moment], [&self.guide, &next.guide])?)
    }

    /// The object at each pixel, 0 for none.
    pub fn objects(&self) -> &[u32] {
        &self.guide.id
    }
}

/// Checks that a picture has room for a block.
pub fn check_room(path: &Path, picture: &Picture, block_px: u32) -> Result {
    let (width, height) = (picture.width(), picture.height());
    if width.min(height) < block_px {
        let text = format!("has {width} x {height} pixels, but --block-size {block_px} needs {block_px} x {block_px}");
        return Err(Failure::file(path, text));
    }
    Ok(())
}

/// The stages of measuring on a device.
pub struct Meter {
    search: BlockSearch,
    way: SearchFlags,
}

/// A strip that is searched.
pub struct Strip {
    source: Source,
    tree: Option<KdTree>,
}

impl Meter {
    /// Makes ready to measure.
    pub fn new(way: &SearchFlags, device: &Device) -> Result<Self> {
        Ok(Meter { search: BlockSearch::new(&device.context, way.nearest)?, way: way.clone() })
    }

    /// Makes ready to compare frames, where nothing is searched.
    pub fn of_frames(device: &Device) -> Result<Self> {
        Self::new(&SearchFlags { nearest: 1, search: SearchName::Exact }, device)
    }

    /// Prepares the strip in file `path` to be searched.
    pub fn strip(&self, device: &mut Device, path: &Path, strip: &Picture, block_px: u32) -> Result<Strip> {
        let fail = |error: impasto::Error| match error {
            // The library knows nothing of flags.
            impasto::Error::Parameter { .. } => Failure::file(path, format!("{error} (--nearest, --block-size)")),
            error => Failure::file(path, error),
        };
        let source = self.search.source(&mut device.runner, strip, block_px).map_err(fail)?;
        let tree = match self.way.search {
            SearchName::Exact => None,
            SearchName::Kdtree => Some(KdTree::new(&source).map_err(fail)?),
        };
        Ok(Strip { source, tree })
    }

    /// The features of a frame's pixels.
    pub fn features(
        &self,
        device: &mut Device,
        frame: &Picture,
        block_px: u32,
        pixels: &[(u32, u32)],
    ) -> Result<Vec<Features>> {
        Ok(self.search.features(&mut device.runner, frame, block_px, pixels)?)
    }

    /// The source pixels that are nearest to a frame's pixels.
    pub fn nearest(
        &self,
        session: &Session,
        device: &mut Device,
        strip: &Strip,
        frame: &Picture,
        pixels: &[(u32, u32)],
    ) -> Result<Vec<Vec<Neighbour>>> {
        let tested = self.features(device, frame, strip.source.block_px(), pixels)?;
        let mut found = Vec::with_capacity(tested.len());
        let progress = session.progress("searching", tested.len().div_ceil(TOGETHER));
        for tested in tested.chunks(TOGETHER) {
            found.extend(match &strip.tree {
                None => self.search.nearest(&mut device.runner, &strip.source, tested)?,
                Some(tree) => tree.nearest(tested, self.way.nearest)?,
            });
            progress.step();
        }
        Ok(found)
    }
}

impl Strip {
    /// Width of the strip, pixels.
    pub fn width(&self) -> u32 {
        self.source.width()
    }
}

/// A frame and the next, and where pixels of the one are in the other.
pub struct Pair<'a> {
    frame: &'a Picture,
    next: &'a Picture,
    in_next: Eligible,
    block_px: u32,
}

impl<'a> Pair<'a> {
    /// Two frames of one size.
    pub fn new(frame: &'a Picture, next: &'a Picture, block_px: u32) -> Self {
        Pair { frame, next, in_next: Eligible::new(next, block_px), block_px }
    }

    /// Where a pixel is in the next frame: at the same place, or where its surface has moved to. `None` where the block
    /// there does not lie inside the object, or the surface is hidden.
    pub fn place(&self, motion: Option<&Motion>, x: u32, y: u32) -> Option<(u32, u32)> {
        let place = motion.map_or(Some((x, y)), |motion| motion.pixel(x, y));
        place.filter(|&(x, y)| self.in_next.contains(x, y))
    }

    /// Coherence at pixels that have a place in the next frame (thesis 9.3).
    pub fn coherence(
        &self,
        meter: &Meter,
        device: &mut Device,
        motion: Option<&Motion>,
        pixels: &[(u32, u32)],
    ) -> Result<Vec<f64>> {
        let there: Vec<(u32, u32)> = pixels.iter().filter_map(|&(x, y)| self.place(motion, x, y)).collect();
        let first = meter.features(device, self.frame, self.block_px, pixels)?;
        let second = meter.features(device, self.next, self.block_px, &there)?;
        Ok(coherence(&first, &second, self.block_px))
    }
}

/// The pixels of a map: every so many pixels, so that the longer side has [`MAP_CELLS`] cells or as many as `step`
/// says.
pub struct Grid {
    step: u32,
    width: u32,
    height: u32,
    pixels: Vec<(u32, u32)>,
}

impl Grid {
    /// The grid over a frame, without the pixels that may not be measured or that `also` refuses.
    pub fn new(frame: &Picture, block_px: u32, step: Option<u32>, also: impl Fn(u32, u32) -> bool) -> Result<Self> {
        let step = step.unwrap_or_else(|| frame.width().max(frame.height()).div_ceil(MAP_CELLS)).max(1);
        let eligible = Eligible::new(frame, block_px);
        let (width, height) = (frame.width().div_ceil(step), frame.height().div_ceil(step));
        let cells = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        // The pixel in the middle of what the frame has of each cell.
        let middle = |cell: u32, side: u32| (cell * step + ((cell + 1) * step).min(side)) / 2;
        let pixels = cells.map(|(x, y)| (middle(x, frame.width()), middle(y, frame.height())));
        let pixels: Vec<_> = pixels.filter(|&(x, y)| eligible.contains(x, y) && also(x, y)).collect();
        if pixels.is_empty() {
            return Err(Failure::new(format!(
                "the map has no cell inside the object; a --map-step below {step} may help"
            )));
        }
        Ok(Grid { step, width, height, pixels })
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

    /// The newer measures of a texture against its sample; what pictures are too small for is left out, with a warning.
    pub fn textures(&mut self, sample: &Picture, frame: &Picture, session: &mut Session) {
        let cooccurrence = cooccurrence_error(sample, frame, &CooccurrenceParams::default());
        let wasserstein = sliced_wasserstein(sample, frame, &WassersteinParams::default());
        for (name, value) in [("cooccurrence_error", cooccurrence), ("sliced_wasserstein", wasserstein)] {
            match value {
                Ok(value) => self.number(name, value),
                Err(error) => session.warn(format!("{} is left out: {error}", name.replace('_', " "))),
            }
        }
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
