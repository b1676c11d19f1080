//! How calm two frames are, how sharp and how large strokes are: by values worked by hand.

use super::common::Numbers;
use super::noise_picture;
use impasto::metric::{frame_difference, sharpness, stroke_size, Motion, Picture};

/// A motion that takes every pixel the same way, in 1/64 px.
fn motion(width: u32, height: u32, right: i32, down: i32) -> Motion {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("motion.png");
    let texel = [(32_768 + right) as u16, (32_768 + down) as u16, u16::MAX];
    let picture = image::ImageBuffer::<image::Rgb<u16>, Vec<u16>>::from_pixel(width, height, image::Rgb(texel));
    picture.save(&path).expect("saved");
    Motion::load(&path).expect("a motion")
}

fn picture(width: u32, height: u32, pixel: impl Fn(u32, u32) -> [u8; 4]) -> Picture {
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| pixel(x, y));
    Picture::new(width, height, pixels.collect()).expect("a picture")
}

fn gray(value: u32) -> [u8; 4] {
    [value as u8, value as u8, value as u8, 255]
}

fn near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-12, "{found} is not {expected}");
}

/// One object all over.
fn whole(picture: &Picture) -> Vec<u32> {
    vec![1; picture.pixels().len()]
}

#[test]
fn paint_that_goes_along_by_whole_pixels_is_perfectly_calm() {
    let frame = noise_picture(24, 16, 5);
    let moved = picture(24, 16, |x, y| frame.pixels()[((y + 13) % 16 * 24 + (x + 22) % 24) as usize]);
    let found = frame_difference(&frame, &moved, &motion(24, 16, 2 * 64, 3 * 64)).expect("a difference");
    assert_eq!((found.nearest, found.bilinear, found.pixels), (0.0, 0.0, 22 * 13));
    let still = frame_difference(&frame, &moved, &motion(24, 16, 0, 0)).expect("a difference");
    assert!(still.nearest > 0.1 && still.nearest == still.bilinear && still.pixels == 24 * 16, "{still:?}");
}

#[test]
fn the_difference_is_that_worked_by_hand() {
    // Half a pixel to the right is nearest to the pixel on the right: 0 -> 51, 51 -> 153; between: 25.5 and 102.
    let frame = picture(3, 1, |x, _| [gray(0), gray(51), gray(0)][x as usize]);
    let next = picture(3, 1, |x, _| [gray(0), gray(51), gray(153)][x as usize]);
    let found = frame_difference(&frame, &next, &motion(3, 1, 32, 0)).expect("a difference");
    assert_eq!(found.pixels, 2);
    near(found.nearest, (51.0 + 102.0) / 2.0 / 255.0);
    near(found.bilinear, (25.5 + 51.0) / 2.0 / 255.0);
    // A quarter to the right and a quarter down: weights 9, 3, 3, 1 sixteenths; nearest is the pixel itself.
    let colors = [[32, 64, 96, 255], [16, 0, 0, 255], [0, 16, 0, 255], [0, 0, 48, 255]];
    let next = picture(2, 2, |x, y| colors[(y * 2 + x) as usize]);
    let frame = picture(2, 2, |_, _| gray(0));
    let found = frame_difference(&frame, &next, &motion(2, 2, 16, 16)).expect("a difference");
    assert_eq!(found.pixels, 1);
    near(found.nearest, (32.0 + 64.0 + 96.0) / 3.0 / 255.0);
    near(found.bilinear, ((9.0 * 32.0 + 3.0 * 16.0) + (9.0 * 64.0 + 3.0 * 16.0) + (9.0 * 96.0 + 48.0)) / 48.0 / 255.0);
}

#[test]
fn what_is_outside_of_either_frame_does_not_count() {
    // Column 0 is outside of the frame, column 4 of the next one; half a pixel to the right looks at both neighbours.
    let frame = picture(6, 1, |x, _| if x == 0 { [0; 4] } else { gray(100) });
    let next = picture(6, 1, |x, _| if x == 4 { [9, 9, 9, 254] } else { gray(100) });
    let found = frame_difference(&frame, &next, &motion(6, 1, 32, 0)).expect("a difference");
    assert_eq!((found.nearest, found.bilinear, found.pixels), (0.0, 0.0, 2));
    let nothing = picture(6, 1, |_, _| [0; 4]);
    let error = frame_difference(&frame, &nothing, &motion(6, 1, 0, 0)).expect_err("refused").to_string();
    assert!(error.contains("surface points"), "{error}");
    let error = frame_difference(&frame, &next, &motion(5, 1, 0, 0)).expect_err("refused").to_string();
    assert!(error.contains("motion is 5 x 1"), "{error}");
    assert!(frame_difference(&frame, &picture(5, 1, |_, _| gray(0)), &motion(6, 1, 0, 0)).is_err());
}

#[test]
fn the_sharpness_of_ramps_is_their_slope_and_outlines_have_none() {
    // 3 across and 4 down to a pixel: a slope of 5.
    let ramp = picture(9, 7, |x, y| gray(3 * x + 4 * y));
    near(sharpness(&ramp, &whole(&ramp)).expect("a sharpness"), 5.0 / 255.0);
    // A step of 200 between two objects, and a background as bright as nothing else.
    let step = picture(12, 7, |x, _| {
        if x < 4 {
            gray(0)
        } else if x < 8 {
            gray(200)
        } else {
            [255, 255, 255, 0]
        }
    });
    let objects: Vec<u32> = step.pixels().iter().map(|pixel| u32::from(pixel[0] > 0) + 1).collect();
    assert_eq!(sharpness(&step, &objects).expect("a sharpness"), 0.0);
    // As one object, the two columns beside the step have half of it, and those at the picture's edge do not count.
    near(sharpness(&step, &whole(&step)).expect("a sharpness"), 2.0 / 6.0 * 100.0 / 255.0);
    assert!(sharpness(&step, &objects[1..]).is_err());
    assert!(sharpness(&step, &vec![0; 84]).expect_err("refused").to_string().contains("3 x 3"));
}

#[test]
fn the_size_of_strokes_is_that_worked_by_hand() {
    // Squares of 2 x 2 on 8 x 8: of 7 pairs of neighbours in a row 4 are alike and 3 are opposite: 1 / 7.
    let squares = picture(8, 8, |x, y| gray(255 * ((x / 2 + y / 2) % 2)));
    let size = stroke_size(&squares, &whole(&squares)).expect("inside").expect("a size");
    near(size, 0.5 / (1.0 - 1.0 / 7.0));
    // Pairs of two objects do not count: with every other column another, there are none along rows.
    let mut objects = whole(&squares);
    objects.iter_mut().step_by(2).for_each(|object| *object = 2);
    assert_eq!(stroke_size(&squares, &objects).expect("inside"), None);
    let flat = picture(8, 8, |_, _| gray(77));
    assert_eq!(stroke_size(&flat, &whole(&flat)).expect("inside"), None);
    assert!(stroke_size(&flat, &vec![0; 64]).expect_err("refused").to_string().contains("inside"));
    assert!(stroke_size(&flat, &[1]).is_err());
}

#[test]
fn blurred_noise_has_the_size_of_its_blur_and_less_sharpness() {
    let mut numbers = Numbers(7);
    let noise: Vec<u32> = (0..160 * 120).map(|_| numbers.next() >> 24).collect();
    let blurred = |side: u32| {
        picture(152, 112, |x, y| {
            let square = (0..side * side).map(|k| (y + k / side) * 160 + x + k % side);
            gray(square.map(|at| noise[at as usize]).sum::<u32>() / (side * side))
        })
    };
    // A box of n pixels makes an autocorrelation that falls to 0 over n pixels, along a straight line.
    let mut sharp = f64::INFINITY;
    for side in [1, 2, 4, 8] {
        let picture = blurred(side);
        let size = stroke_size(&picture, &whole(&picture)).expect("inside").expect("a size");
        let expected = f64::from(side) / 2.0;
        assert!((size - expected).abs() < 0.1 * expected, "{side}: {size}");
        let here = sharpness(&picture, &whole(&picture)).expect("a sharpness");
        assert!(here < 0.7 * sharp, "{side}: {here} after {sharp}");
        sharp = here;
    }
}
