//! Copies of a picture that are turned or stretched.

use super::super::Picture;
use crate::{Error, Result};

/// A copy of the same size, turned about the picture's centre by `angle_rad`, anticlockwise as one looks at it.
///
/// Colours are interpolated between the four nearest pixels. Pixels that come from outside of the picture, or for which
/// one of the four does not count, have all values 0, so that [`Eligible`](super::super::Eligible) leaves them out. An
/// angle that is not finite leaves nothing.
pub fn rotated(picture: &Picture, angle_rad: f64) -> Picture {
    let (width, height) = (picture.width(), picture.height());
    let (sin, cos) = angle_rad.sin_cos();
    let centre = (f64::from(width - 1) / 2.0, f64::from(height - 1) / 2.0);
    let pixel = |place: u32| {
        let (dx, dy) = (f64::from(place % width) - centre.0, f64::from(place / width) - centre.1);
        // Rows count downwards, so that this turns the place back clockwise.
        bilinear(picture, centre.0 + dx * cos - dy * sin, centre.1 + dx * sin + dy * cos)
    };
    picture.map_places(pixel)
}

/// The colour at a place between pixels, whose centres have whole coordinates.
fn bilinear(picture: &Picture, x: f64, y: f64) -> [u8; 4] {
    // Right angles leave the whole coordinates of the outermost pixels by the last bits of a float.
    const SLACK: f64 = 1e-6;
    let inside = |at: f64, side: u32| (-SLACK..=f64::from(side - 1) + SLACK).contains(&at);
    if !inside(x, picture.width()) || !inside(y, picture.height()) {
        return [0; 4];
    }
    let split = |at: f64, side: u32| {
        let at = at.clamp(0.0, f64::from(side - 1));
        let low = at.floor();
        (low as usize, (low as usize + 1).min(side as usize - 1), at - low)
    };
    let ((x0, x1, right), (y0, y1, down)) = (split(x, picture.width()), split(y, picture.height()));
    let at = |x: usize, y: usize| picture.pixels()[y * picture.width() as usize + x].map(f64::from);
    let mix = |a: [f64; 4], b: [f64; 4], t: f64| [0, 1, 2, 3].map(|i| a[i] + (b[i] - a[i]) * t);
    quantized(mix(mix(at(x0, y0), at(x1, y0), right), mix(at(x0, y1), at(x1, y1), right), down))
}

/// 8-bit values of a mixed pixel; one that has something of a pixel that does not count does not count either.
fn quantized(mixed: [f64; 4]) -> [u8; 4] {
    if mixed[3] < 255.0 - 1e-3 {
        return [0; 4];
    }
    let [r, g, b, _] = mixed.map(|value| value.round() as u8);
    [r, g, b, 255]
}

/// A copy that is `x_factor` times as wide and `y_factor` times as high, rounded to whole pixels.
///
/// Shrinking takes the mean over the area that a pixel of the copy covers, so that nothing is skipped; growing
/// interpolates linearly between neighbouring pixels, and goes on evenly beyond the outermost. Each direction is done
/// by itself. A factor of 1 changes nothing. A pixel that has something of one that does not count is all 0.
///
/// # Errors
/// [`Error::Parameter`] for a factor that is not a positive number, and where a side of the copy would be 0 or more than
/// [`MAX_PICTURE_SIDE_PX`](super::super::MAX_PICTURE_SIDE_PX).
pub fn scaled(picture: &Picture, x_factor: f64, y_factor: f64) -> Result<Picture> {
    let side = |name, side: u32, factor: f64| match factor > 0.0 && factor.is_finite() {
        // Beyond the range of u32 this is its largest value, which is refused below.
        true => Ok((f64::from(side) * factor).round() as u32),
        false => Err(Error::parameter(name, factor, "a positive number")),
    };
    let width = side("x_factor", picture.width(), x_factor)?;
    let height = side("y_factor", picture.height(), y_factor)?;
    Picture::check_sides(width, height)?;
    let (across, down) = (shares(picture.width(), width), shares(picture.height(), height));
    let stride = picture.width() as usize;
    let wide: Vec<[f64; 4]> = picture
        .pixels()
        .chunks_exact(stride)
        .flat_map(|row| across.iter().map(|shares| weighted(shares, |x| row[x].map(f64::from))))
        .collect();
    let pixels = down.iter().flat_map(|shares| {
        let wide = &wide;
        (0..width as usize).map(move |x| quantized(weighted(shares, |y| wide[y * width as usize + x])))
    });
    Picture::new(width, height, pixels.collect())
}

/// What each pixel of a side of `to` pixels takes of which pixels of a side of `from`; its shares add up to 1.
fn shares(from: u32, to: u32) -> Vec<Vec<(usize, f64)>> {
    let step = f64::from(from) / f64::from(to);
    let last = from as usize - 1;
    let shrunk = |at: u32| {
        let (begin, end) = (f64::from(at) * step, (f64::from(at) * step + step).min(f64::from(from)));
        let of_pixel = |x: usize| (x, ((x as f64 + 1.0).min(end) - (x as f64).max(begin)) / (end - begin));
        (begin as usize..=(end as usize).min(last)).map(of_pixel).filter(|(_, share)| *share > 0.0).collect()
    };
    let grown = |at: u32| {
        let place = ((f64::from(at) + 0.5) * step - 0.5).clamp(0.0, last as f64);
        let (low, part) = (place as usize, place.fract());
        vec![(low, 1.0 - part), ((low + 1).min(last), part)]
    };
    (0..to).map(|at| if to <= from { shrunk(at) } else { grown(at) }).collect()
}

fn weighted(shares: &[(usize, f64)], value: impl Fn(usize) -> [f64; 4]) -> [f64; 4] {
    let mut sum = [0.0; 4];
    for &(at, share) in shares {
        sum.iter_mut().zip(value(at)).for_each(|(sum, value)| *sum += share * value);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::super::TestTexture;
    use super::*;
    use std::f64::consts::PI;

    fn gray(width: u32, height: u32, values: &[u8]) -> Picture {
        let pixels = values.iter().map(|&value| [value, value, value, 255]);
        Picture::new(width, height, pixels.collect()).expect("a picture")
    }

    fn values(picture: &Picture) -> Vec<u8> {
        picture.pixels().iter().map(|pixel| pixel[0]).collect()
    }

    #[test]
    fn right_angles_are_exact_turns() {
        for side in [32, 33] {
            let picture = TestTexture::Diagonal.picture(side, 5).expect("a texture");
            type Place = fn(u32, u32, u32) -> (u32, u32);
            let turns: [(f64, Place); 4] = [
                (0.0, |x, y, _| (x, y)),
                // Anticlockwise: what was at the right edge comes to the top.
                (PI / 2.0, |x, y, last| (last - y, x)),
                (PI, |x, y, last| (last - x, last - y)),
                (-PI / 2.0, |x, y, last| (y, last - x)),
            ];
            for (angle, from) in turns {
                let turned = rotated(&picture, angle);
                for (place, pixel) in (0..).zip(turned.pixels()) {
                    let (x, y) = from(place % side, place / side, side - 1);
                    let want = picture.pixels()[(y * side + x) as usize];
                    assert!(
                        pixel.iter().zip(want).all(|(a, b)| a.abs_diff(b) <= 1),
                        "{place}: {pixel:?}, not {want:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn other_angles_interpolate_inside_and_leave_the_corners_out() {
        // A ramp to the right, turned anticlockwise by 60 degrees, climbs to the right by half and upwards.
        let ramp = gray(41, 41, &(0..41 * 41).map(|place| (place % 41 * 4) as u8).collect::<Vec<_>>());
        let turned = rotated(&ramp, PI / 3.0);
        for (place, pixel) in (0..).zip(turned.pixels()) {
            let (dx, dy) = (f64::from(place % 41) - 20.0, f64::from(place / 41) - 20.0);
            let (x, y) = (dx / 2.0 - dy * 0.75_f64.sqrt(), dx * 0.75_f64.sqrt() + dy / 2.0);
            if x.abs().max(y.abs()) > 20.0 {
                assert_eq!(*pixel, [0; 4], "{place}");
            } else {
                assert_eq!(pixel[3], 255, "{place}");
                assert!((f64::from(pixel[0]) - (80.0 + 4.0 * x)).abs() <= 0.51, "{place}: {pixel:?}");
            }
        }
        assert!(rotated(&ramp, f64::NAN).pixels().iter().all(|pixel| *pixel == [0; 4]));
    }

    #[test]
    fn a_factor_of_1_changes_nothing() {
        let picture = TestTexture::Random.picture(50, 2).expect("a texture");
        assert_eq!(scaled(&picture, 1.0, 1.0).expect("a copy"), picture);
        assert_eq!(rotated(&picture, 0.0), picture);
    }

    #[test]
    fn shrinking_takes_means_and_growing_interpolates() {
        let row = gray(6, 1, &[0, 10, 20, 30, 40, 250]);
        assert_eq!(values(&scaled(&row, 0.5, 1.0).expect("a copy")), [5, 25, 145]);
        // 1.5 pixels each: (0 + 10 / 2) / 1.5, and so on.
        assert_eq!(values(&scaled(&row, 2.0 / 3.0, 1.0).expect("a copy")), [3, 17, 33, 180]);
        let column = gray(1, 2, &[0, 100]);
        assert_eq!(values(&scaled(&column, 1.0, 2.0).expect("a copy")), [0, 25, 75, 100]);
        let both = scaled(&gray(2, 2, &[0, 100, 100, 200]), 2.0, 0.5).expect("a copy");
        assert_eq!((both.width(), both.height(), values(&both)), (4, 1, vec![50, 75, 125, 150]));
    }

    #[test]
    fn what_does_not_count_stays_out() {
        let mut pixels = vec![[9, 9, 9, 255]; 8 * 8];
        pixels[3 * 8 + 3][3] = 0;
        let picture = Picture::new(8, 8, pixels).expect("a picture");
        let outside = |picture: &Picture| picture.pixels().iter().filter(|pixel| **pixel == [0; 4]).count();
        assert_eq!(outside(&scaled(&picture, 0.5, 0.5).expect("a copy")), 1);
        // Of 16 pixels across, two lie on either side of the hole's centre and nearer than a pixel to it.
        assert_eq!(outside(&scaled(&picture, 2.0, 1.0).expect("a copy")), 4);
        assert_eq!(outside(&rotated(&picture, PI)), 1);
    }

    #[test]
    fn factors_that_leave_no_picture_are_refused() {
        let picture = gray(4, 4, &[7; 16]);
        for factor in [0.0, -1.0, f64::NAN, f64::INFINITY, 0.1, 5000.0, 1e300] {
            assert!(scaled(&picture, factor, 1.0).is_err() && scaled(&picture, 1.0, factor).is_err(), "{factor}");
        }
    }
}
