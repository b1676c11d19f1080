//! Values of flags: sizes, vectors, lights, colours. Each parser's error says what form is wanted.

use impasto::scene::{DirectionalLight, Vec3};
use std::str::FromStr;

/// Largest side of a picture that any command makes, in pixels. A device may allow less.
pub const MAX_SIDE_PX: u32 = 16384;

/// `WIDTHxHEIGHT` in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Size {
    /// Pixels across, 1 to [`MAX_SIDE_PX`].
    pub width: u32,
    /// Pixels down, 1 to [`MAX_SIDE_PX`].
    pub height: u32,
}

impl Size {
    /// (width, height).
    pub fn pair(self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// Width over height.
    pub fn aspect(self) -> f32 {
        self.width as f32 / self.height as f32
    }
}

impl std::fmt::Display for Size {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("must be WIDTHxHEIGHT, like 512x512, with sides of 1 to {MAX_SIDE_PX} pixels");
        let (width, height) = text.split_once(['x', 'X']).ok_or_else(wrong)?;
        let side = |text: &str| text.parse().ok().filter(|side| (1..=MAX_SIDE_PX).contains(side)).ok_or_else(wrong);
        Ok(Size { width: side(width)?, height: side(height)? })
    }
}

/// Reads `X,Y,Z`, three finite numbers.
pub fn vector(text: &str) -> Result<Vec3, String> {
    let numbers: Vec<f32> = text.split(',').map_while(|part| part.trim().parse().ok()).collect();
    match numbers[..] {
        [x, y, z] if numbers.iter().all(|n| n.is_finite()) && text.split(',').count() == 3 => Ok(Vec3::new(x, y, z)),
        _ => Err("must be three numbers X,Y,Z".into()),
    }
}

/// Reads `X,Y,Z` or `X,Y,Z@INTENSITY`: the direction towards a light, and its weight among several.
pub fn light(text: &str) -> Result<DirectionalLight, String> {
    let (direction, intensity) = match text.split_once('@') {
        None => (text, Some(1.0)),
        Some((direction, intensity)) => (direction, intensity.trim().parse().ok()),
    };
    let direction = vector(direction).map_err(|_| "must be X,Y,Z or X,Y,Z@INTENSITY".to_owned())?;
    let intensity = intensity.ok_or("must be X,Y,Z@INTENSITY with a number for the intensity")?;
    DirectionalLight::new(direction, intensity).map_err(|error| error.to_string())
}

/// Reads `#RRGGBB`.
pub fn color(text: &str) -> Result<[u8; 3], String> {
    let wrong = || "must be a colour like #ff8800".to_owned();
    let digits = text.strip_prefix('#').ok_or_else(wrong)?;
    if digits.len() != 6 || !digits.bytes().all(|byte| byte.is_ascii_hexdigit()) {
        return Err(wrong());
    }
    let [_, r, g, b] = u32::from_str_radix(digits, 16).map_err(|_| wrong())?.to_be_bytes();
    Ok([r, g, b])
}

/// A finite number.
pub fn finite(text: &str) -> Result<f32, String> {
    text.parse().ok().filter(|number: &f32| number.is_finite()).ok_or_else(|| "must be a number".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read_and_limited() {
        assert_eq!("640x480".parse(), Ok(Size { width: 640, height: 480 }));
        assert_eq!("1X16384".parse(), Ok(Size { width: 1, height: 16384 }));
        for wrong in ["", "640", "0x5", "5x0", "16385x1", "-1x5", "4x4x4", "x", "4294967297x1", "3.5x2"] {
            let message = wrong.parse::<Size>().expect_err(wrong);
            assert!(message.contains("16384"), "{wrong}: {message}");
        }
    }

    #[test]
    fn vectors_lights_and_colours_are_read() {
        assert_eq!(vector("-1,2.5, 3"), Ok(Vec3::new(-1.0, 2.5, 3.0)));
        for wrong in ["", "1,2", "1,2,3,4", "1,2,x", "NaN,0,0", "inf,0,0", "1,2,3,x"] {
            assert!(vector(wrong).is_err(), "{wrong}");
        }
        let light_of = |text| light(text).map(|l| (l.direction(), l.intensity()));
        assert_eq!(light_of("0,-2,0"), Ok((Vec3::new(0.0, -1.0, 0.0), 1.0)));
        assert_eq!(light_of("0,0,1@0.5"), Ok((Vec3::Z, 0.5)));
        for wrong in ["0,0,0", "0,0,1@", "0,0,1@-1", "0,0,1@NaN", "1@2"] {
            assert!(light(wrong).is_err(), "{wrong}");
        }
        assert_eq!(color("#10fF00"), Ok([16, 255, 0]));
        for wrong in ["", "#", "#12345", "#1234567", "102030", "#gg0000", "#+12345"] {
            assert!(color(wrong).is_err(), "{wrong}");
        }
    }
}
