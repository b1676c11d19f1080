//! Colour stops: a path through colour space written by hand (figure 4.4(b) of the thesis).

use std::str::FromStr;

use crate::error::{Error, Result};

/// A colour and its place on a trajectory. Written as text it is `s:#rrggbb`, for example `0.5:#ff8800`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ColorStop {
    /// The place, from 0 (darkest shade) to 1 (lightest shade).
    pub s: f32,
    /// The colour, each channel in 0..1.
    pub rgb: [f32; 3],
}

impl ColorStop {
    /// Reads stops from text like `0:#102030,0.5:#ff8800,1:#ffffff`.
    ///
    /// # Errors
    /// A stop that is not of this form. Ranges and order are checked by
    /// [`Trajectory::from_stops`](super::Trajectory::from_stops).
    pub fn parse_list(text: &str) -> Result<Vec<ColorStop>> {
        text.split(',').map(str::parse).collect()
    }
}

impl FromStr for ColorStop {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let parse = || {
            let (s, color) = text.split_once(':')?;
            let digits = color.trim().strip_prefix('#')?;
            if digits.len() != 6 || !digits.bytes().all(|byte| byte.is_ascii_hexdigit()) {
                return None;
            }
            let [_, r, g, b] = u32::from_str_radix(digits, 16).ok()?.to_be_bytes();
            Some(ColorStop { s: s.trim().parse().ok()?, rgb: [r, g, b].map(|byte| f32::from(byte) / 255.0) })
        };
        parse().ok_or_else(|| Error::parameter("stops", text, "places and colours like 0:#102030,1:#ffffff"))
    }
}
