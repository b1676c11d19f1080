//! Paint strips on the command line: loading one, taking it apart, giving it other colours.

use super::failure::{Failure, Result};
use super::report::number;
use super::session::Session;
use clap::{Args, ValueEnum};
use impasto::paint::{
    ColorStop, PaintSample, Residual, SpeedCurve, TextureDifference, Timing, Trajectory, TrajectoryOptions,
};
use serde_json::{json, Value};
use std::path::Path;

/// Rows of a trajectory's picture, which are all the same.
const TRAJECTORY_ROWS: u32 = 32;

/// How a strip is taken apart.
#[derive(Args, Debug, Clone)]
pub struct StripFlags {
    /// Scale of the search for the strip's colours; try 1.25 to 2 where a strongly curved path is cut short
    #[arg(long, value_name = "F", default_value_t = 1.0, allow_negative_numbers = true)]
    search_scale: f32,
    /// How the colours are spread over the strip
    #[arg(long, value_enum, default_value_t)]
    timing: TimingFlag,
    /// Correction of the timing: a rising curve through x:y,x:y,... with x and y from 0 to 1, like 0.5:0.3
    #[arg(long, value_name = "X:Y,X:Y")]
    speed: Option<SpeedCurve>,
}

/// [`Timing`] as a flag.
#[derive(ValueEnum, Debug, Clone, Copy, PartialEq, Eq, Default)]
enum TimingFlag {
    /// Each colour stands where the strip has it
    #[default]
    Fit,
    /// The colours are spread evenly
    Stretch,
}

/// A strip, taken apart.
pub struct Strip {
    /// The strip.
    pub sample: PaintSample,
    /// Its colours.
    pub trajectory: Trajectory,
    /// Its brush texture.
    pub texture: TextureDifference,
}

impl StripFlags {
    fn options(&self, timing: Timing) -> TrajectoryOptions {
        TrajectoryOptions { search_scale: self.search_scale, timing, speed: self.speed.clone() }
    }

    fn timing(&self) -> Timing {
        match self.timing {
            TimingFlag::Fit => Timing::Fit,
            TimingFlag::Stretch => Timing::Stretch,
        }
    }

    /// Takes a strip apart; `name` is what a warning calls it.
    pub fn separate(&self, sample: PaintSample, name: &str, session: &mut Session) -> Result<Strip> {
        if let Some(hint) = sample.strip_hint() {
            session.warn(format!("{name}: {hint}"));
        }
        let trajectory = Trajectory::extract(&sample, &self.options(self.timing()))?;
        let texture = TextureDifference::extract(&sample, &trajectory);
        Ok(Strip { sample, trajectory, texture })
    }

    /// How far the trajectories of both timings are from the strip.
    pub fn residuals(&self, strip: &PaintSample) -> Result<[(&'static str, Residual); 2]> {
        let of =
            |timing| -> Result<Residual> { Ok(Trajectory::extract(strip, &self.options(timing))?.residual(strip)) };
        Ok([("fit", of(Timing::Fit)?), ("stretch", of(Timing::Stretch)?)])
    }

    /// The trajectory that `--gradient` asks for: colour stops, or the colours of another strip. The speed curve is the
    /// first strip's own and is not applied to the other one.
    pub fn gradient(&self, text: &str, len: usize) -> Result<Trajectory> {
        let path = Path::new(text);
        if text.contains(":#") && !path.exists() {
            return Ok(Trajectory::from_stops(&ColorStop::parse_list(text)?, len)?);
        }
        let strip = PaintSample::load(path).map_err(|error| {
            let form = "a strip's picture, or stops like 0:#102030,1:#ffffff";
            Failure::new(format!("--gradient: {error} (wanted: {form})"))
        })?;
        let options = TrajectoryOptions { speed: None, ..self.options(self.timing()) };
        Ok(Trajectory::extract(&strip, &options)?)
    }

    /// Adds the flags to the report.
    pub fn report(&self, session: &mut Session) {
        session.parameter("search_scale", number(self.search_scale));
        session.parameter("timing", format!("{:?}", self.timing).to_lowercase());
        let points = self
            .speed
            .as_ref()
            .map(|speed| speed.points().map(|(x, y)| json!([number(x), number(y)])).collect::<Vec<Value>>());
        session.parameter("speed", json!(points));
    }
}

/// A trajectory as a picture, dark end on the left: one column per colour.
pub fn trajectory_picture(trajectory: &Trajectory) -> image::RgbaImage {
    let colors = trajectory.colors();
    image::RgbaImage::from_fn(colors.len() as u32, TRAJECTORY_ROWS, |x, _| {
        let [r, g, b] = colors[x as usize].map(|value| (value * 255.0).round() as u8);
        image::Rgba([r, g, b, 255])
    })
}
