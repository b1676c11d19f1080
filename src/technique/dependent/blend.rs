//! How much of which slice a face takes, seen from a direction (thesis chapter 8).
//!
//! The thesis only says that the slice whose direction is closest weighs most. The weights here follow C. Buehler et
//! al., *Unstructured Lumigraph Rendering* (2001): a slice's weight is 0 when it joins or leaves the nearest few.

use glam::Vec3;

/// The most slices that are blended for one face.
pub const MAX_BLENDED: usize = 4;

/// Threshold of a set that has no slice beyond the nearest few: more than the largest distance, which is 2.
const FAR: f32 = 2.5;
/// Added to a distance before it divides. The smaller, the more a slice has its own direction to itself.
const SOFTNESS: f32 = 1e-4;

/// The slices of a set, and their weights, that a face takes when seen from `direction` (a unit vector from the middle
/// of the model towards the eye). `directions` are the unit vectors of all slices, in the same sense; `set` holds
/// indices into it, ascending; thesis chapter 8.
///
/// A shader does the same in 32-bit floats, in this order:
///
/// 1. The distance of slice i is a = 0.5 (x x + y y + z z), with (x, y, z) = its direction - `direction`. That is 1 -
///    the cosine of the angle between the two, 0 to 2, but exact for small angles as well.
/// 2. The [`MAX_BLENDED`] nearest take part, of equally near ones those that come first in the set. The threshold T is
///    the distance of the next nearest, or 2.5 if there is none.
/// 3. Each weighs max(0, T - a) / (a + 0.0001).
/// 4. The weights are added, nearest first, and each is divided by the sum. If the sum is 0 the nearest takes all.
///
/// The result has the nearest slice first; weights are 0 to 1 and their sum is 1; unused entries are (0, 0.0). Entries
/// of `set` that `directions` does not have are left out. If nothing is left, all entries are (0, 0.0).
///
/// Weights change continuously with the direction, the faster the smaller T - a of the nearest slice is, and jump only
/// where `MAX_BLENDED` + 1 slices of the set are the nearest ones at exactly the same distance.
pub fn blend_weights(directions: &[Vec3], set: &[u8], direction: Vec3) -> [(u8, f32); MAX_BLENDED] {
    // The nearest so far and the one after them, which gives the threshold.
    let mut nearest = [(0_u8, FAR); MAX_BLENDED + 1];
    let mut found = 0;
    for &slice in set {
        let Some(&of_slice) = directions.get(usize::from(slice)) else { continue };
        let apart = of_slice - direction;
        let distance = 0.5 * (apart.x * apart.x + apart.y * apart.y + apart.z * apart.z);
        if let Some(place) = nearest.iter().position(|kept| distance < kept.1) {
            nearest[place..].rotate_right(1);
            nearest[place] = (slice, distance);
            found += 1;
        }
    }
    let threshold = nearest[MAX_BLENDED].1;
    let mut weights = [(0, 0.0); MAX_BLENDED];
    let mut sum = 0.0;
    for (weight, &(slice, distance)) in weights.iter_mut().zip(&nearest).take(found) {
        *weight = (slice, (threshold - distance).max(0.0) / (distance + SOFTNESS));
        sum += weight.1;
    }
    if sum > 0.0 {
        weights.iter_mut().for_each(|weight| weight.1 /= sum);
    } else if found > 0 {
        weights[0].1 = 1.0;
    }
    weights
}
