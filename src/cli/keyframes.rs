//! What lies between keyframes: straight or smooth, for numbers, points and directions alike.

use glam::DVec3;
use std::f64::consts::PI;
use std::ops::{Add, Mul};

/// A frame's number, and what is given for it. Lists of keys rise.
pub type Key<T> = (u32, T);

/// What can be given by keys: there is a way from any one to any other, and parts of a way can be gone.
pub trait Value: Copy {
    /// From one to another; twice as much leads twice as far.
    type Way: Add<Output = Self::Way> + Mul<f64, Output = Self::Way>;

    fn way_to(self, other: Self) -> Self::Way;

    fn gone(self, way: Self::Way) -> Self;

    fn mixed(self, other: Self, part: f64) -> Self {
        self.gone(self.way_to(other) * part)
    }
}

impl Value for f64 {
    type Way = f64;

    fn way_to(self, other: f64) -> f64 {
        other - self
    }

    fn gone(self, way: f64) -> f64 {
        self + way
    }
}

impl Value for DVec3 {
    type Way = DVec3;

    fn way_to(self, other: DVec3) -> DVec3 {
        other - self
    }

    fn gone(self, way: DVec3) -> DVec3 {
        self + way
    }
}

/// A unit vector; the ways are arcs of great circles, as tangents that are as long as the arc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Direction(DVec3);

impl Direction {
    /// `None` for a vector that is zero or not finite.
    pub fn new(vector: DVec3) -> Option<Self> {
        vector.try_normalize().map(Direction)
    }

    pub fn unit(self) -> DVec3 {
        self.0
    }

    /// Whether no way between the two is shorter than all others.
    pub fn is_opposite(self, other: Self) -> bool {
        (self.0 + other.0).length() < 1e-6
    }
}

impl Value for Direction {
    type Way = DVec3;

    fn way_to(self, other: Direction) -> DVec3 {
        let along = self.0.dot(other.0);
        let across = other.0 - along * self.0;
        match across.try_normalize() {
            Some(across_unit) => across_unit * across.length().atan2(along),
            None if along < 0.0 => self.0.any_orthonormal_vector() * PI,
            None => DVec3::ZERO,
        }
    }

    fn gone(self, way: DVec3) -> Direction {
        let Some(unit) = way.try_normalize() else { return self };
        let (sin, cos) = way.length().sin_cos();
        Direction((self.0 * cos + unit * sin).normalize())
    }
}

/// What keys have at a frame: theirs at their own, the nearest key's outside of them, and something in between
/// elsewhere. `None` if there are no keys.
///
/// If `smooth`, by a Catmull-Rom spline: through a key goes the mean speed from the key before to the key after, and
/// through the first and the last that to their only neighbour.
pub fn between<T: Value>(keys: &[Key<T>], smooth: bool, frame: u32) -> Option<T> {
    let next = keys.partition_point(|(at, _)| *at < frame);
    let Some(&(to, b)) = keys.get(next) else { return keys.last().map(|(_, value)| *value) };
    if to == frame || next == 0 {
        return Some(b);
    }
    let (from, a) = keys[next - 1];
    let frames = f64::from(to - from);
    let part = f64::from(frame - from) / frames;
    if !smooth {
        return Some(a.mixed(b, part));
    }
    // The spline as a Bézier curve, by de Casteljau's steps: they need nothing but mixing, so they work on the sphere.
    let third = frames / 3.0;
    let mut points = [a, a.gone(speed(keys, next - 1) * third), b.gone(speed(keys, next) * -third), b];
    for last in (0..3).rev() {
        for i in 0..=last {
            points[i] = points[i].mixed(points[i + 1], part);
        }
    }
    Some(points[0])
}

/// The way per frame at a key of two or more.
fn speed<T: Value>(keys: &[Key<T>], index: usize) -> T::Way {
    let here = keys[index].1;
    let (from, before) = keys[index.saturating_sub(1)];
    let (to, after) = keys[(index + 1).min(keys.len() - 1)];
    (here.way_to(after) + here.way_to(before) * -1.0) * (1.0 / f64::from(to - from))
}

/// The keys that count at a frame: those between the two cuts around it. Where there are none, the last key before it
/// counts, or else the first of all.
pub fn of_shot<'a, T>(keys: &'a [Key<T>], cuts: &[u32], frame: u32) -> &'a [Key<T>] {
    let cut = cuts.partition_point(|cut| *cut <= frame);
    let key_at = |cut: u32| keys.partition_point(|(at, _)| *at < cut);
    let first = cut.checked_sub(1).map_or(0, |before| key_at(cuts[before]));
    let end = cuts.get(cut).map_or(keys.len(), |after| key_at(*after));
    if first < end {
        return &keys[first..end];
    }
    let one = first.saturating_sub(1);
    &keys[one..keys.len().min(one + 1)]
}

#[cfg(test)]
mod tests {
    use super::*;

    const KEYS: [Key<f64>; 4] = [(10, 0.0), (20, 90.0), (25, -30.0), (60, 5.0)];

    #[test]
    fn keys_are_joined_by_lines_and_hold_outside() {
        for (frame, value) in [(0, 0.0), (10, 0.0), (15, 45.0), (20, 90.0), (60, 5.0), (99, 5.0)] {
            assert_eq!(between(&KEYS, false, frame), Some(value), "{frame}");
        }
        assert_eq!(between::<f64>(&[], true, 5), None);
        assert_eq!(between(&KEYS[..1], true, 15), Some(0.0));
        assert_eq!(between(&KEYS[..2], true, 15), Some(45.0), "two keys leave nothing to round off");
    }

    #[test]
    fn a_smooth_way_goes_through_its_keys_at_the_neighbours_mean_speed() {
        for (frame, value) in KEYS {
            assert_eq!(between(&KEYS, true, frame), Some(value));
        }
        // Ten times as many frames, for a fine difference. Hermite's cubic with its known tangents is the reference.
        let fine = KEYS.map(|(frame, value)| (frame * 1000, value));
        let at = |frame: u32| between(&fine, true, frame).expect("a value");
        for (frame, speed) in [(20_000, -30.0 / 15.0), (25_000, -85.0 / 40.0)] {
            let before = (at(frame) - at(frame - 1)) * 1000.0;
            let after = (at(frame + 1) - at(frame)) * 1000.0;
            assert!((before - speed).abs() < 0.02 && (after - speed).abs() < 0.02, "{before} {after}, not {speed}");
        }
        let middle = (90.0 - 30.0) / 2.0 + 5.0 / 8.0 * (-2.0 + 85.0 / 40.0);
        assert!((at(22_500) - middle).abs() < 1e-9, "{} is not {middle}", at(22_500));
    }

    #[test]
    fn directions_stay_on_the_sphere_and_take_the_short_way() {
        let of = |x, y, z| Direction::new(DVec3::new(x, y, z)).expect("a direction");
        let keys = [(0, of(1.0, 0.0, 0.0)), (9, of(0.0, 3.0, 0.0)), (18, of(0.0, 0.0, 1.0)), (27, of(0.0, 0.0, 1.0))];
        let third = between(&keys, false, 3).expect("a direction").unit();
        assert!((third - DVec3::new(30f64.to_radians().cos(), 0.5, 0.0)).length() < 1e-12, "{third}");
        for frame in 0..=27 {
            let at = |smooth| between(&keys, smooth, frame).expect("a direction").unit();
            assert!((at(true).length() - 1.0).abs() < 1e-12 && (at(false).length() - 1.0).abs() < 1e-12);
            assert!(frame % 9 != 0 || at(true) == at(false), "{frame}");
            assert!((at(true) - at(false)).length() < 0.3, "{frame}");
        }
        // An even turn in one plane has nothing to be rounded off.
        let turn = [(0, of(1.0, 0.0, 0.0)), (10, of(1.0, 1.0, 0.0)), (20, of(0.0, 1.0, 0.0))];
        let (smooth, straight) = (between(&turn, true, 13), between(&turn, false, 13));
        assert!((smooth.expect("one").unit() - straight.expect("one").unit()).length() < 1e-12);
        // Where no way is the shortest, one is taken all the same.
        let (x, back) = (of(1.0, 0.0, 0.0), of(-1.0, 0.0, 0.0));
        assert!(x.is_opposite(back) && x.mixed(back, 0.5).unit().dot(x.unit()).abs() < 1e-12);
    }

    #[test]
    fn a_cut_parts_the_keys() {
        let shot = |frame| of_shot(&KEYS, &[12, 25, 30, 70], frame).iter().map(|(at, _)| *at).collect::<Vec<_>>();
        assert_eq!(shot(0), [10]);
        assert_eq!(shot(11), [10]);
        assert_eq!(shot(12), [20]);
        assert_eq!(shot(24), [20]);
        assert_eq!(shot(25), [25]);
        assert_eq!(shot(30), [60]);
        assert_eq!(shot(70), [60], "no key after the cut: the last one holds");
        assert_eq!(of_shot(&KEYS, &[5], 0), &KEYS[..1], "no key before the cut: the first one counts");
        assert_eq!(of_shot(&KEYS, &[], 99), KEYS);
        assert!(of_shot::<f64>(&[], &[5], 9).is_empty());
    }
}
