//! Random numbers as a function of what they are for, so that they do not depend on the order in which they are asked
//! for.

/// 32 random bits for `number`, for a `purpose`, of a `seed`.
///
/// The hash "lowbias32" of C. Wellons (2018) behind the golden ratio as increment, three times, as in quilt.glsl.
pub(crate) fn bits(seed: u32, number: u32, purpose: u32) -> u32 {
    let mix = |x: u32| {
        let x = x.wrapping_add(0x9e37_79b9);
        let x = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
        let x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
        x ^ (x >> 16)
    };
    mix(mix(mix(seed) ^ number) ^ purpose)
}

/// A random number in [0, 1).
pub(crate) fn unit(seed: u32, number: u32, purpose: u32) -> f64 {
    f64::from(bits(seed, number, purpose)) / (f64::from(u32::MAX) + 1.0)
}
