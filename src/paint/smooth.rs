//! Two smoothers: one that follows a straight ramp exactly, and one that keeps a rising sequence rising.
//!
//! Both weigh neighbours with the triweight kernel (1 - t^2)^3, a bell without an exponential: plain products give the
//! same bits on every machine.

use super::rgb::Rgb;

/// Weights of the neighbours at distance 0, 1, 2, ... for a kernel that reaches `half_width` (and not beyond `reach`).
fn kernel(half_width: f64, reach: usize) -> Vec<f64> {
    let bell = |distance: usize| {
        let t = distance as f64 / half_width.max(1.0);
        let u = 1.0 - t * t;
        if t < 1.0 {
            u * u * u
        } else {
            0.0
        }
    };
    (0..=reach).map(bell).take_while(|&weight| weight > 0.0).collect()
}

/// Low-passes a row of colours: at each place the value of the straight line fitted to the weighted neighbours (local
/// linear regression). Unlike a moving average it neither flattens a ramp nor drags its ends towards the middle.
pub(super) fn low_pass(colors: &[Rgb], half_width: f64) -> Vec<Rgb> {
    let Some(last) = colors.len().checked_sub(1) else { return Vec::new() };
    let kernel = kernel(half_width, last);
    let reach = kernel.len() - 1;
    (0..=last)
        .map(|center| {
            let (mut s0, mut s1, mut s2) = (0.0, 0.0, 0.0);
            let (mut value, mut slope) = ([0.0; 3], [0.0; 3]);
            for at in center.saturating_sub(reach)..=(center + reach).min(last) {
                let (weight, x) = (kernel[at.abs_diff(center)], at as f64 - center as f64);
                s0 += weight;
                s1 += weight * x;
                s2 += weight * x * x;
                for k in 0..3 {
                    value[k] += weight * colors[at][k];
                    slope[k] += weight * x * colors[at][k];
                }
            }
            let determinant = s0 * s2 - s1 * s1;
            if determinant <= 0.0 {
                return colors[center]; // no neighbour within reach
            }
            std::array::from_fn(|k| ((s2 * value[k] - s1 * slope[k]) / determinant).clamp(0.0, 1.0))
        })
        .collect()
}

/// Smooths a non-decreasing sequence by a weighted mean, so that it stays non-decreasing. Beyond its ends the sequence
/// is continued point-symmetrically: both end values stay, and a straight sequence stays straight.
pub(super) fn smooth_rising(values: &[f64], half_width: f64) -> Vec<f64> {
    let Some(last) = values.len().checked_sub(1) else { return Vec::new() };
    let kernel = kernel(half_width, last);
    let total = kernel[0] + 2.0 * kernel[1..].iter().sum::<f64>();
    let (first_value, last_value) = (values[0], values[last]);
    (0..=last)
        .map(|center| {
            let mut sum = kernel[0] * values[center];
            for (distance, weight) in kernel.iter().enumerate().skip(1) {
                let before = match center.checked_sub(distance) {
                    Some(at) => values[at],
                    None => 2.0 * first_value - values[distance - center],
                };
                let after = match center + distance {
                    at if at <= last => values[at],
                    at => 2.0 * last_value - values[2 * last - at],
                };
                sum += weight * (before + after);
            }
            sum / total
        })
        .collect()
}
