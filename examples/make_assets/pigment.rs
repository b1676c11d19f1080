//! Colours and how wet paints mix.
//!
//! Mixed paint is not the mean of its colours: the pigments' absorptions add up. The Kubelka-Munk theory (P. Kubelka,
//! F. Munk, 1931) gives for an opaque layer of reflectance R the ratio of absorption to scattering
//! K/S = (1 - R)^2 / (2 R), and it is K/S that mixes linearly. So a little dark paint goes a long way, and mixtures
//! are deeper and more saturated than a plain average.

use glam::DVec3;

/// Red, green and blue as stored in an image, scaled to 0..1.
pub type Colour = DVec3;

/// A colour from the bytes of an image.
pub fn from_bytes(rgb: [u8; 3]) -> Colour {
    DVec3::from(rgb.map(|v| f64::from(v) / 255.0))
}

/// The absorption to scattering ratio of an opaque layer, for each channel.
///
/// The reflectance is taken as the square of the stored value, which is close to sRGB's curve; it is kept off 0,
/// where the ratio has its pole.
fn absorption(colour: Colour) -> DVec3 {
    let r = (colour * colour).clamp(DVec3::splat(0.002), DVec3::ONE);
    (DVec3::ONE - r) * (DVec3::ONE - r) / (2.0 * r)
}

/// The colour of an opaque layer: Kubelka and Munk's R = 1 + K/S - sqrt((K/S)^2 + 2 K/S).
fn reflected(ratio: DVec3) -> Colour {
    let root = |v: DVec3| DVec3::from(v.to_array().map(|x| x.max(0.0).sqrt()));
    root(DVec3::ONE + ratio - root(ratio * ratio + 2.0 * ratio))
}

/// Two paints mixed wet, with the part `share` of `b`.
pub fn mix(a: Colour, b: Colour, share: f64) -> Colour {
    reflected(absorption(a).lerp(absorption(b), share.clamp(0.0, 1.0)))
}
