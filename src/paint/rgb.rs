//! Colours as points of RGB space, in double precision for the arithmetic within this room.

/// A colour; public interfaces carry it as `[f32; 3]`.
pub(super) type Rgb = [f64; 3];

pub(super) fn widen(colors: &[[f32; 3]]) -> Vec<Rgb> {
    colors.iter().map(|color| color.map(f64::from)).collect()
}

pub(super) fn narrow(color: Rgb) -> [f32; 3] {
    color.map(|value| value as f32)
}

pub(super) fn dot(a: Rgb, b: Rgb) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn sub(a: Rgb, b: Rgb) -> Rgb {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(super) fn distance_squared(a: Rgb, b: Rgb) -> f64 {
    dot(sub(a, b), sub(a, b))
}

/// From `a` (t = 0, exactly) towards `b` (t = 1).
pub(super) fn lerp(a: Rgb, b: Rgb, t: f64) -> Rgb {
    std::array::from_fn(|k| a[k] + (b[k] - a[k]) * t)
}

/// The polyline through `points` at a position counted in points; clamped to its ends. `points` must not be empty.
pub(super) fn along(points: &[Rgb], position: f64) -> Rgb {
    let last = points.len() - 1;
    let position = position.clamp(0.0, last as f64);
    let index = position as usize;
    if index == last {
        return points[last];
    }
    lerp(points[index], points[index + 1], position - index as f64)
}
