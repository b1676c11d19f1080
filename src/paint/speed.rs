//! The artist's speed curve: how fast a trajectory is travelled (end of section 4.1 of the thesis).

use std::str::FromStr;

use crate::error::{Error, Result};

/// A rising curve from strip position x to path position y, both in 0..1, given by control points.
///
/// The colour that the trajectory had at y is shown at x: a steep curve passes through the colours fast, a flat one
/// lingers. Between the points the curve is a monotone cubic (F. N. Fritsch and R. E. Carlson, Monotone Piecewise Cubic
/// Interpolation, SIAM J. Numer. Anal. 17, 1980; slopes by weighted harmonic means), so it never overshoots or turns
/// back. Written as text it is `x:y,x:y`, for example `0.5:0.3,0.8:0.9`.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeedCurve {
    points: Vec<(f64, f64)>,
    slopes: Vec<f64>,
}

impl SpeedCurve {
    /// A curve through the control points (x, y), in order of x. The ends (0, 0) and (1, 1) are added where no point
    /// has x = 0 or x = 1; no points at all give the identity.
    ///
    /// # Errors
    /// A coordinate outside of 0..1 (or not a number), x that does not increase, y that decreases.
    pub fn new(points: Vec<(f32, f32)>) -> Result<Self> {
        let show = |(x, y): (f32, f32)| format!("{x}:{y}");
        let mut points_f64 = Vec::with_capacity(points.len() + 2);
        if points.first().is_none_or(|point| point.0 != 0.0) {
            points_f64.push((0.0, 0.0));
        }
        for (index, &(x, y)) in points.iter().enumerate() {
            if !(0.0..=1.0).contains(&x) || !(0.0..=1.0).contains(&y) {
                return Err(Error::parameter("speed", show((x, y)), "points x:y with x and y from 0 to 1"));
            }
            if index > 0 && (x <= points[index - 1].0 || y < points[index - 1].1) {
                let both = format!("{},{}", show(points[index - 1]), show((x, y)));
                return Err(Error::parameter("speed", both, "points of increasing x and never decreasing y"));
            }
            points_f64.push((f64::from(x), f64::from(y)));
        }
        if points.last().is_none_or(|point| point.0 != 1.0) {
            points_f64.push((1.0, 1.0));
        }
        let slopes = monotone_slopes(&points_f64);
        Ok(Self { points: points_f64, slopes })
    }

    /// The control points (x, y), the ends included.
    pub fn points(&self) -> impl Iterator<Item = (f32, f32)> + '_ {
        self.points.iter().map(|&(x, y)| (x as f32, y as f32))
    }

    /// The path position in 0..1 that is shown at the strip position `x`, which is clamped to 0..1.
    pub fn at(&self, x: f64) -> f64 {
        // Written so that NaN becomes 0.
        let x = if x > 0.0 { x.min(1.0) } else { 0.0 };
        let after = self.points.partition_point(|point| point.0 <= x);
        if after == self.points.len() {
            return self.points[after - 1].1;
        }
        let ((x0, y0), (x1, y1)) = (self.points[after - 1], self.points[after]);
        let (m0, m1) = (self.slopes[after - 1], self.slopes[after]);
        let (width, rise) = (x1 - x0, y1 - y0);
        let t = (x - x0) / width;
        // Cubic Hermite polynomial with the end slopes m0 and m1, as a departure from y0.
        let y =
            y0 + t * (width * m0 + t * (3.0 * rise - width * (2.0 * m0 + m1) + t * (width * (m0 + m1) - 2.0 * rise)));
        y.clamp(y0, y1)
    }
}

/// Slopes at the points that keep the cubic between them monotone: 0 beside a level piece, otherwise the harmonic mean
/// of the neighbouring secants weighted by the piece lengths (at most three times either, the bound of Fritsch and
/// Carlson); at the ends the secant itself.
fn monotone_slopes(points: &[(f64, f64)]) -> Vec<f64> {
    let pieces: Vec<(f64, f64)> = points
        .windows(2)
        .map(|pair| (pair[1].0 - pair[0].0, (pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0)))
        .collect();
    let mut slopes = vec![pieces[0].1];
    slopes.extend(pieces.windows(2).map(|pair| {
        let ((h0, d0), (h1, d1)) = (pair[0], pair[1]);
        let (w0, w1) = (2.0 * h1 + h0, h1 + 2.0 * h0);
        if d0 > 0.0 && d1 > 0.0 {
            (w0 + w1) / (w0 / d0 + w1 / d1)
        } else {
            0.0
        }
    }));
    slopes.push(pieces[pieces.len() - 1].1);
    slopes
}

impl FromStr for SpeedCurve {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let number = |text: &str| text.trim().parse::<f32>().ok();
        let points: Option<Vec<(f32, f32)>> = text
            .split(',')
            .map(|point| {
                let (x, y) = point.split_once(':')?;
                Some((number(x)?, number(y)?))
            })
            .collect();
        Self::new(points.ok_or_else(|| Error::parameter("speed", text, "control points like 0.5:0.3,0.8:0.9"))?)
    }
}
