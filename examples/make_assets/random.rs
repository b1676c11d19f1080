//! A small seeded random number generator: SplitMix64 (S. Steele, D. Lea, C. Flood, "Fast Splittable Pseudorandom
//! Number Generators", 2014). The same seed gives the same numbers everywhere and always.

use glam::DVec2;

/// The generator's state.
pub struct Random(u64);

impl Random {
    /// Starts the sequence of a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number in `low`..`high`.
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        // The upper 53 bits fill the mantissa exactly.
        low + (high - low) * ((self.bits() >> 11) as f64 / (1u64 << 53) as f64)
    }

    /// A number in -1..1, small ones more often: the sum of two even ones (a triangular distribution).
    pub fn spread(&mut self) -> f64 {
        self.range(-0.5, 0.5) + self.range(-0.5, 0.5)
    }

    /// A direction, all equally likely.
    pub fn direction(&mut self) -> DVec2 {
        loop {
            let p = DVec2::new(self.range(-1.0, 1.0), self.range(-1.0, 1.0));
            // Keeping to the disc makes the directions even; its very middle has none.
            if (0.01..1.0).contains(&p.length_squared()) {
                return p.normalize();
            }
        }
    }

    /// Puts a list into a random order.
    pub fn shuffle<T>(&mut self, list: &mut [T]) {
        for i in (1..list.len()).rev() {
            list.swap(i, self.range(0.0, (i + 1) as f64) as usize);
        }
    }
}

/// Random values at even places, joined smoothly: which bristles stick together, where a brush trembles.
pub struct Noise(Vec<f64>);

impl Noise {
    /// `count` values in -1..1, at least two.
    pub fn new(random: &mut Random, count: usize) -> Self {
        Self((0..count.max(2)).map(|_| random.range(-1.0, 1.0)).collect())
    }

    /// The value at `t` in 0..1.
    pub fn at(&self, t: f64) -> f64 {
        let place = t.clamp(0.0, 1.0) * (self.0.len() - 1) as f64;
        let i = (place as usize).min(self.0.len() - 2);
        let f = place - i as f64;
        self.0[i] + (self.0[i + 1] - self.0[i]) * f * f * (3.0 - 2.0 * f)
    }
}
