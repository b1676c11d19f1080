//! The colour trajectory of a strip (section 4.1 of the thesis): its colour transition without the brush texture.

use super::path::sorted_path;
use super::rgb::{along, distance_squared, lerp, narrow, widen, Rgb};
use super::sample::PaintSample;
use super::smooth::low_pass;
use super::speed::SpeedCurve;
use super::stops::ColorStop;
use super::timing::{self, low_pass_half_width};
use crate::error::{Error, Result};

/// How the sorted path is spread over the strip's columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Timing {
    /// Each colour stands where the strip has it, by a smooth monotone fit.
    #[default]
    Fit,
    /// The thesis's plain stretch: the kept colours, evenly spaced.
    Stretch,
}

/// How a trajectory is drawn from a strip.
#[derive(Debug, Clone, PartialEq)]
pub struct TrajectoryOptions {
    /// Scale of the search area about the midpoint of two neighbours; finite and at least 0. 1 is the sphere whose
    /// diameter they are. A strongly curved path is clipped there and wants more: try 1.25, then up to 2. More lets
    /// ever more streaks in; 0 gives the straight blend of the end colours.
    pub search_scale: f32,
    /// How the path is spread over the columns.
    pub timing: Timing,
    /// The artist's correction upon that.
    pub speed: Option<SpeedCurve>,
}

impl Default for TrajectoryOptions {
    fn default() -> Self {
        Self { search_scale: 1.0, timing: Timing::default(), speed: None }
    }
}

/// How far a trajectory is from a strip's low-passed column means, in units of the colour range 0..1.
///
/// The low-pass reaches a tenth of the strip's width to both sides. What is left over here is colour transition that
/// the texture difference keeps by mistake.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Residual {
    /// Root of the mean square over all columns and channels.
    pub rms: f32,
    /// The largest deviation of a channel in any column.
    pub max: f32,
}

/// A colour for every shade: a path through colour space, from the darkest shade (s = 0) to the lightest (s = 1).
///
/// It is a row of colours with linear interpolation between them. Colour `i` of `n` stands at s = i / (n - 1), so the
/// end colours stand at s = 0 and s = 1; a single colour stands everywhere. A trajectory that was drawn from a strip
/// has one colour per pixel column: colour `i` belongs to column `i`, exactly.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    colors: Vec<[f32; 3]>,
    kept_columns: Vec<u32>,
}

impl Trajectory {
    /// Draws the trajectory from a strip: column means, the sorted path through them, its timing, the speed curve.
    ///
    /// A strip of one colour, of one column, or with equal end colours gives a trajectory like any other.
    ///
    /// # Errors
    /// A search scale that is negative or not finite.
    pub fn extract(strip: &PaintSample, options: &TrajectoryOptions) -> Result<Self> {
        let scale = options.search_scale;
        if !scale.is_finite() || scale < 0.0 {
            return Err(Error::parameter("search_scale", scale, "a finite number, 0 or more"));
        }
        let means = widen(&strip.column_means());
        let path = sorted_path(&means, f64::from(scale), low_pass_half_width(means.len()));
        let timed = match options.timing {
            Timing::Fit => timing::fit(&means, &path),
            Timing::Stretch => timing::stretch(&means, &path),
        };
        let timed = match &options.speed {
            Some(speed) => respeed(&timed, speed),
            None => timed,
        };
        let kept_columns = path.into_iter().map(|column| column as u32).collect();
        Ok(Self { colors: timed.into_iter().map(narrow).collect(), kept_columns })
    }

    /// A trajectory from its colours, evenly spaced.
    ///
    /// # Errors
    /// No colours, or a channel outside of 0..1.
    pub fn from_colors(colors: Vec<[f32; 3]>) -> Result<Self> {
        if colors.is_empty() {
            return Err(Error::parameter("colors", "empty", "at least one colour"));
        }
        if let Some(value) = colors.as_flattened().iter().find(|value| !(0.0..=1.0).contains(*value)) {
            return Err(Error::parameter("colors", value, "channels from 0 to 1"));
        }
        Ok(Self { colors, kept_columns: Vec::new() })
    }

    /// A trajectory of `len` colours, linear between the stops and constant beyond the outermost ones. Of stops at the
    /// same place the first colours what comes before it and the last what comes after: a step.
    ///
    /// # Errors
    /// No stops, places outside of 0..1 or out of order, a channel outside of 0..1, a `len` of 0.
    pub fn from_stops(stops: &[ColorStop], len: usize) -> Result<Self> {
        let Some(last) = stops.last() else {
            return Err(Error::parameter("stops", "empty", "at least one colour stop"));
        };
        if let Some(stop) = stops.iter().find(|stop| !(0.0..=1.0).contains(&stop.s)) {
            return Err(Error::parameter("stops", stop.s, "at places from 0 to 1"));
        }
        if let Some(pair) = stops.windows(2).find(|pair| pair[1].s < pair[0].s) {
            return Err(Error::parameter("stops", format!("{},{}", pair[0].s, pair[1].s), "in ascending order"));
        }
        check_len(len)?;
        let color = |s: f64| {
            let after = stops.partition_point(|stop| f64::from(stop.s) <= s);
            match (after.checked_sub(1), stops.get(after)) {
                (None, _) => stops[0].rgb,
                (_, None) => last.rgb,
                (Some(before), Some(b)) => {
                    let a = &stops[before];
                    let t = (s - f64::from(a.s)) / (f64::from(b.s) - f64::from(a.s));
                    narrow(lerp(a.rgb.map(f64::from), b.rgb.map(f64::from), t))
                }
            }
        };
        Self::from_colors((0..len).map(|index| color(place(index, len))).collect())
    }

    /// The colours, evenly spaced from s = 0 to s = 1; at least one.
    pub fn colors(&self) -> &[[f32; 3]] {
        &self.colors
    }

    /// The number of colours, at least 1.
    #[allow(clippy::len_without_is_empty)] // never empty
    pub fn len(&self) -> usize {
        self.colors.len()
    }

    /// The columns of the strip whose means make up the sorted path, in the order of the path; ascending where the
    /// strip's columns were in order already. Empty for a trajectory that was not drawn from a strip.
    pub fn kept_columns(&self) -> &[u32] {
        &self.kept_columns
    }

    /// The colour at `s`, which is clamped to 0..1.
    pub fn at(&self, s: f32) -> [f32; 3] {
        // Written so that NaN becomes 0.
        let s = if s > 0.0 { s.min(1.0) } else { 0.0 };
        self.at_position(f64::from(s) * (self.len() - 1) as f64)
    }

    /// The colour at a position counted in colours, from 0 to `len - 1`.
    fn at_position(&self, position: f64) -> [f32; 3] {
        let index = (position as usize).min(self.len() - 1);
        match self.colors.get(index + 1) {
            Some(after) => {
                narrow(lerp(self.colors[index].map(f64::from), after.map(f64::from), position - index as f64))
            }
            None => self.colors[index],
        }
    }

    /// The same trajectory with `len` colours. With its own length it is unchanged; one colour is that in its middle.
    ///
    /// # Errors
    /// A `len` of 0.
    pub fn resampled(&self, len: usize) -> Result<Self> {
        check_len(len)?;
        Ok(Self { colors: self.row(len), kept_columns: self.kept_columns.clone() })
    }

    /// The colours for `width` columns; its own ones, untouched, for as many columns as it has colours.
    pub(super) fn row(&self, width: usize) -> Vec<[f32; 3]> {
        if width == self.len() {
            return self.colors.clone();
        }
        let last = (self.len() - 1) as f64;
        (0..width).map(|column| self.at_position(place(column, width) * last)).collect()
    }

    /// How far the trajectory is from the strip's own colour transition.
    pub fn residual(&self, strip: &PaintSample) -> Residual {
        let means = widen(&strip.column_means());
        let smooth = low_pass(&means, low_pass_half_width(means.len()));
        let own = widen(&self.row(means.len()));
        let square: f64 = smooth.iter().zip(&own).map(|(&a, &b)| distance_squared(a, b)).sum();
        let largest = smooth.as_flattened().iter().zip(own.as_flattened()).map(|(a, b)| (a - b).abs());
        Residual { rms: (square / (3 * means.len()) as f64).sqrt() as f32, max: largest.fold(0.0, f64::max) as f32 }
    }

    /// The trajectory as a table: the header `s,r,g,b`, then one line per colour.
    pub fn to_csv(&self) -> String {
        let mut csv = String::from("s,r,g,b\n");
        for (index, [r, g, b]) in self.colors.iter().enumerate() {
            csv.push_str(&format!("{},{r},{g},{b}\n", place(index, self.len()) as f32));
        }
        csv
    }
}

/// Where colour `index` of `len` stands; a single colour stands for the middle.
fn place(index: usize, len: usize) -> f64 {
    if len == 1 {
        return 0.5;
    }
    index as f64 / (len - 1) as f64
}

fn check_len(len: usize) -> Result<()> {
    if len == 0 {
        return Err(Error::parameter("len", len, "at least 1"));
    }
    Ok(())
}

/// Shows at each place s the colour that stood at `speed.at(s)`.
fn respeed(colors: &[Rgb], speed: &SpeedCurve) -> Vec<Rgb> {
    let last = (colors.len() - 1) as f64;
    (0..colors.len()).map(|index| along(colors, speed.at(place(index, colors.len())) * last)).collect()
}
