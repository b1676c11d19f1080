//! When the sorted path is where: the stretch of the thesis, and the fit that undoes its shift.
//!
//! The recursion drops colours, more in one part of a strip than in another. Stretched evenly to the strip's width, the
//! path then shows its colours in other columns than the strip does, and the difference leaks into the texture. The
//! fit places the path's colours where the strip has them, without ever turning back, smoothly.

use super::rgb::{along, distance_squared, lerp, Rgb};
use super::smooth::{low_pass, smooth_rising};

/// Reach of the low-pass that tells a strip's colour transition from its brush strokes, as a share of the width.
const LOW_PASS_SHARE: f64 = 1.0 / 10.0;
/// Reach of the smoothing of the fitted positions, as a share of the width.
const SMOOTHING_SHARE: f64 = 1.0 / 16.0;
/// More columns than these are fitted at evenly spaced ones, and interpolated.
const MAX_KNOTS: usize = 512;

/// Reach in columns of the low-pass for a strip of `width` columns.
pub(super) fn low_pass_half_width(width: usize) -> f64 {
    LOW_PASS_SHARE * width as f64
}

/// The path `colors[path]` stretched evenly over as many columns as there are `colors`: linear interpolation.
pub(super) fn stretch(colors: &[Rgb], path: &[usize]) -> Vec<Rgb> {
    let kept: Vec<Rgb> = path.iter().map(|&column| colors[column]).collect();
    let step = (kept.len() - 1) as f64 / (colors.len() - 1).max(1) as f64;
    (0..colors.len()).map(|column| along(&kept, column as f64 * step)).collect()
}

/// The path `colors[path]` re-timed over as many columns as there are `colors`: each column gets the path's colour that
/// matches the strip's low-passed colour there, by a position on the path that never falls and changes smoothly.
///
/// The columns look for their colours on the path, and not the kept colours for their columns: so the dropped columns
/// have a say, and what is made small is the very thing that would leak into the texture difference.
pub(super) fn fit(colors: &[Rgb], path: &[usize]) -> Vec<Rgb> {
    let width = colors.len();
    if width < 3 {
        return stretch(colors, path);
    }
    let track = divide_hops(colors, path);
    let smooth = low_pass(colors, low_pass_half_width(width));
    let mut knots: Vec<usize> = (0..width - 1).step_by(width.div_ceil(MAX_KNOTS)).collect();
    knots.push(width - 1);
    let targets: Vec<Rgb> = knots.iter().map(|&knot| smooth[knot]).collect();
    let positions = interpolate(&knots, &match_rising(&targets, &track));
    let positions = smooth_rising(&positions, SMOOTHING_SHARE * width as f64);
    positions.into_iter().map(|position| along(&track, position)).collect()
}

/// The path as a polyline without long hops: each is divided into pieces of about an even share of the whole path's
/// length (one column's worth), so that a gap in the path becomes a ramp and not a step.
fn divide_hops(colors: &[Rgb], path: &[usize]) -> Vec<Rgb> {
    let length = |pair: &[usize]| distance_squared(colors[pair[0]], colors[pair[1]]).sqrt();
    let share = path.windows(2).map(length).sum::<f64>() / (colors.len() - 1) as f64;
    let mut track = vec![colors[path[0]]];
    for pair in path.windows(2) {
        let pieces = if share > 0.0 { (length(pair) / share).round().max(1.0) as usize } else { 1 };
        let (from, to) = (colors[pair[0]], colors[pair[1]]);
        track.extend((1..pieces).map(|piece| lerp(from, to, piece as f64 / pieces as f64)));
        track.push(to);
    }
    track
}

/// For each target the index of the track's point that it gets: the never falling sequence from the first point to the
/// last that has the least sum of squared colour differences, by dynamic programming. Ties go to the lowest point.
fn match_rising(targets: &[Rgb], track: &[Rgb]) -> Vec<usize> {
    let points = track.len();
    // costs[p]: the least sum for the targets so far, the last of them at point p.
    let mut costs = vec![f64::INFINITY; points];
    costs[0] = 0.0;
    // come_from[target][p]: the previous target's point then.
    let mut come_from = vec![0u32; targets.len() * points];
    for (&target, come_from) in targets.iter().zip(come_from.chunks_exact_mut(points)).skip(1) {
        let mut best = (f64::INFINITY, 0);
        for (point, &color) in track.iter().enumerate() {
            if costs[point] < best.0 {
                best = (costs[point], point as u32);
            }
            come_from[point] = best.1;
            costs[point] = best.0 + distance_squared(target, color);
        }
    }
    let mut matched = vec![points - 1; targets.len()];
    for target in (1..targets.len()).rev() {
        matched[target - 1] = come_from[target * points + matched[target]] as usize;
    }
    matched
}

/// A value for every column from the first knot to the last, linear between the knots, which are columns.
fn interpolate(knots: &[usize], values: &[usize]) -> Vec<f64> {
    let mut all = Vec::new();
    for (knots, values) in knots.windows(2).zip(values.windows(2)) {
        let (from, slope) = (values[0] as f64, (values[1] - values[0]) as f64 / (knots[1] - knots[0]) as f64);
        all.extend((0..knots[1] - knots[0]).map(|step| from + slope * step as f64));
    }
    all.extend(values.last().map(|&value| value as f64));
    all
}
