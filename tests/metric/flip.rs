//! FLIP between two frames: a value worked by hand, and what must hold of its map and mean.

use impasto::metric::{flip, FlipErrors, FlipParams, Picture};

fn picture(width: u32, height: u32, color: impl Fn(u32, u32) -> [u8; 4]) -> Picture {
    let pixels = (0..width * height).map(|i| color(i % width, i / width)).collect();
    Picture::new(width, height, pixels).expect("a picture")
}

fn gray(value: u8) -> [u8; 4] {
    [value, value, value, 255]
}

/// Gray with a square of another gray in the middle.
fn square(value: u8) -> Picture {
    picture(80, 60, |x, y| gray(if (36..44).contains(&x) && (26..34).contains(&y) { value } else { 100 }))
}

fn compare(first: &Picture, second: &Picture) -> FlipErrors {
    flip(first, second, &FlipParams::default()).expect("frames of one size")
}

#[test]
fn black_against_white_by_hand() {
    // Without edges the error is that of colour alone. HyAB is 100, to the power of 0.7 it is 25.12. Between green and
    // blue, the greatest there is, HyAB is 203.3 after Hunt's adjustment, and 41.28 to that power. Above 0.4 of this,
    // which is 16.51, what is left is mapped to 0.95 to 1: 0.95 + 0.05 * (25.12 - 16.51) / (41.28 - 16.51).
    let errors = compare(&picture(20, 10, |_, _| gray(0)), &picture(20, 10, |_, _| gray(255)));
    assert_eq!(errors.map.len(), 200);
    assert!(errors.map.iter().all(|error| (error - 0.9674).abs() < 2e-4), "{:?}", errors.map);
    assert!((errors.mean - 0.9674).abs() < 2e-4, "{}", errors.mean);
}

#[test]
fn a_frame_against_itself_is_zero() {
    let errors = compare(&square(180), &square(180));
    assert_eq!((errors.mean, errors.map), (0.0, vec![0.0; 80 * 60]));
}

#[test]
fn a_change_is_seen_where_it_is_and_grows() {
    let base = square(100);
    let means = [110, 140, 190, 255].map(|value| compare(&base, &square(value)).mean);
    assert!(means[0] > 0.0 && means.windows(2).all(|pair| pair[0] < pair[1]), "{means:?}");

    let errors = compare(&base, &square(255));
    let at = |x: usize, y: usize| errors.map[y * 80 + x];
    assert!(at(40, 30) > 0.5, "{}", at(40, 30));
    assert_eq!([at(0, 0), at(79, 0), at(5, 30), at(40, 59)], [0.0; 4]);
    let mean = errors.map.iter().map(|&error| f64::from(error)).sum::<f64>() / 4800.0;
    assert!((errors.mean - mean).abs() < 1e-12);
    let back = compare(&square(255), &base);
    assert!(back.map.iter().zip(&errors.map).all(|(a, b)| (a - b).abs() < 1e-6));
}

#[test]
fn only_what_is_inside_counts() {
    // Right of the middle nothing is painted, and what lies there has no colour.
    let half = |value: u8| picture(80, 20, move |x, _| if x < 40 { gray(value) } else { [value, 0, 0, 254] });
    let errors = compare(&half(0), &half(255));
    assert!(errors.mean > 0.9, "{}", errors.mean);
    assert!(errors.map.iter().enumerate().all(|(i, &error)| (error == 0.0) == (i % 80 >= 40)));
    let other = picture(80, 20, |x, _| if x < 40 { gray(0) } else { [0, 255, 0, 9] });
    assert_eq!(compare(&half(0), &other).map, [0.0; 1600]);
    // What is inside in one frame only counts.
    let errors = compare(&half(128), &picture(80, 20, |_, _| gray(0)));
    assert!(errors.map.iter().all(|&error| error > 0.5));
}

#[test]
fn fine_detail_is_lost_to_the_eye_from_afar() {
    let flat = picture(64, 64, |_, _| gray(128));
    let checks = picture(64, 64, |x, y| gray(if (x + y) % 2 == 0 { 108 } else { 148 }));
    let mean = |pixels_per_degree| flip(&flat, &checks, &FlipParams { pixels_per_degree }).expect("frames").mean;
    // Light is mixed, not stored values, so that a little is left: the mixture is lighter than the gray.
    let (close, far) = (mean(10.0), mean(67.0));
    assert!(close > 0.3 && far < 0.1, "{close} {far}");
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let told = |first: &Picture, second: &Picture, pixels_per_degree| {
        flip(first, second, &FlipParams { pixels_per_degree }).expect_err("refused").to_string()
    };
    let (frame, nothing) = (square(0), picture(80, 60, |_, _| [0; 4]));
    let other = picture(60, 80, |_, _| gray(0));
    let expected = "size of the second frame is 60 x 80 pixels, but must be that of the first, 80 x 60 pixels";
    assert_eq!(told(&frame, &other, 67.0), expected);
    assert_eq!(told(&nothing, &nothing, 67.0), "number of pixels inside the frames is 0, but must be at least 1");
    for pixels_per_degree in [0.5, 257.0, f32::NAN] {
        assert!(told(&frame, &frame, pixels_per_degree).contains("pixels_per_degree"));
    }
    let large = Picture::new(8192, 4097, vec![[0; 4]; 8192 * 4097]).expect("a picture");
    assert!(told(&large, &large, 67.0).contains("at most 33554432 pixels"));
}
