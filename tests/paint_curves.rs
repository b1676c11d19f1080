//! The artist's hand: speed curves, colour stops, trajectories written by hand.

use impasto::paint::{ColorStop, PaintSample, SpeedCurve, Trajectory, TrajectoryOptions};

type Color = [f32; 3];

fn gray(value: f32) -> Color {
    [value; 3]
}

fn assert_near(a: &[Color], b: &[Color], tolerance: f32) {
    assert_eq!(a.len(), b.len());
    for (index, (a, b)) in a.iter().zip(b).enumerate() {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= tolerance), "colour {index}: {a:?} but {b:?}");
    }
}

// The speed curve.

#[test]
fn speed_curve_passes_through_its_points_and_never_falls() {
    let curve: SpeedCurve = "0.25:0.1, 0.5:0.1,0.6:0.9".parse().expect("a fair curve");
    let points: Vec<(f32, f32)> = curve.points().collect();
    assert_eq!(points, [(0.0, 0.0), (0.25, 0.1), (0.5, 0.1), (0.6, 0.9), (1.0, 1.0)]);
    for (x, y) in points {
        assert!((curve.at(f64::from(x)) - f64::from(y)).abs() < 1e-12);
    }
    assert!((curve.at(0.4) - f64::from(0.1f32)).abs() < 1e-12, "level between equal points");
    let samples: Vec<f64> = (0..=2000).map(|i| curve.at(f64::from(i) / 2000.0)).collect();
    assert!(samples.windows(2).all(|pair| pair[1] >= pair[0] - 1e-15));
    assert!(samples.iter().all(|y| (0.0..=1.0).contains(y)));
    assert_eq!((curve.at(-1.0), curve.at(2.0), curve.at(f64::NAN)), (0.0, 1.0, 0.0));
}

#[test]
fn speed_curve_without_points_is_the_identity() {
    let curve = SpeedCurve::new(Vec::new()).expect("no points are fine");
    assert!((0..=100).map(|i| f64::from(i) / 100.0).all(|x| (curve.at(x) - x).abs() < 1e-12));
}

#[test]
fn speed_curve_at_the_harmonic_slope() {
    // Pieces of slopes 0.5 and 1.5 and equal length: the middle slope is 2 / (1 / 0.5 + 1 / 1.5) = 0.75. At the first
    // piece's middle the Hermite cubic gives (0 + 0.25) / 2 + 0.5 * (0.5 - 0.75) / 8 = 0.109375.
    let curve = SpeedCurve::new(vec![(0.5, 0.25)]).expect("a fair curve");
    assert!((curve.at(0.25) - 0.109375).abs() < 1e-12);
}

#[test]
fn speed_curve_may_start_and_end_within_the_path() {
    let curve: SpeedCurve = "0:0.2,1:0.7".parse().expect("a fair curve");
    assert!((curve.at(0.0) - 0.2).abs() < 1e-7 && (curve.at(1.0) - 0.7).abs() < 1e-7);
    assert!((curve.at(0.5) - 0.45).abs() < 1e-7);
}

#[test]
fn speed_re_times_the_trajectory() {
    let ramp: Vec<Color> = (0..=100).map(|i| gray(i as f32 / 100.0)).collect();
    let strip = PaintSample::from_pixels(101, 1, ramp).expect("sizes match");
    let speed = SpeedCurve::new(vec![(0.5, 0.2)]).expect("a fair curve");
    let options = TrajectoryOptions { speed: Some(speed.clone()), ..Default::default() };
    let trajectory = Trajectory::extract(&strip, &options).expect("fair options");
    let expected: Vec<Color> = (0..=100).map(|i| gray(speed.at(f64::from(i) / 100.0) as f32)).collect();
    assert_near(trajectory.colors(), &expected, 1e-5);
    assert_near(&[trajectory.at(0.5)], &[gray(0.2)], 1e-5);
}

#[test]
fn bad_speed_curves_are_refused() {
    let no_curve = ["", "0.5", "a:b", "0.5:0.2,"];
    let no_order = ["0.5:0.2,0.5:0.3", "0.6:0.2,0.5:0.3", "0.2:0.5,0.4:0.3"];
    let no_range = ["0.5:1.5", "-0.5:0.5", "NaN:0.5", "0.5:inf"];
    for text in no_curve.into_iter().chain(no_order).chain(no_range) {
        let error = text.parse::<SpeedCurve>().expect_err(text).to_string();
        assert!(error.starts_with("speed is ") && error.contains(text), "{error}");
    }
}

// Trajectories by hand.

#[test]
fn stops_are_interpolated_and_extended() {
    let stops = ColorStop::parse_list("0.25:#000000, 0.75:#ff0033").expect("fair stops");
    assert_eq!(stops[1], ColorStop { s: 0.75, rgb: [1.0, 0.0, 0.2] });
    let trajectory = Trajectory::from_stops(&stops, 5).expect("fair stops");
    let expected = [gray(0.0), gray(0.0), [0.5, 0.0, 0.1], [1.0, 0.0, 0.2], [1.0, 0.0, 0.2]];
    assert_near(trajectory.colors(), &expected, 1e-6);
    assert!(trajectory.kept_columns().is_empty());
}

#[test]
fn two_stops_in_one_place_are_a_step() {
    let stops = ColorStop::parse_list("0:#000000,0.5:#000000,0.5:#ffffff").expect("fair stops");
    let trajectory = Trajectory::from_stops(&stops, 5).expect("fair stops");
    assert_eq!(trajectory.colors(), [0.0, 0.0, 1.0, 1.0, 1.0].map(gray));
}

#[test]
fn bad_stops_and_parameters_are_refused() {
    for text in ["", "0#000000", "0:000000", "0:#00000", "0:#00000g", "x:#000000", "0:#000000,", "0:#+12345"] {
        assert!(ColorStop::parse_list(text).is_err(), "{text}");
    }
    let stop = |s, rgb| ColorStop { s, rgb };
    assert!(Trajectory::from_stops(&[], 4).is_err());
    assert!(Trajectory::from_stops(&[stop(0.5, gray(0.0))], 0).is_err());
    assert!(Trajectory::from_stops(&[stop(1.5, gray(0.0))], 4).is_err());
    assert!(Trajectory::from_stops(&[stop(f32::NAN, gray(0.0))], 4).is_err());
    assert!(Trajectory::from_stops(&[stop(0.5, gray(1.5))], 4).is_err());
    assert!(Trajectory::from_stops(&[stop(0.5, gray(0.0)), stop(0.4, gray(0.0))], 4).is_err());
    assert!(Trajectory::from_colors(Vec::new()).is_err());
    assert!(Trajectory::from_colors(vec![gray(f32::NAN)]).is_err());
    assert!(Trajectory::from_colors(vec![gray(0.5)]).expect("one is enough").resampled(0).is_err());
    let strip = PaintSample::from_pixels(1, 1, vec![gray(0.5)]).expect("sizes match");
    for search_scale in [-0.1, f32::NAN, f32::INFINITY] {
        let options = TrajectoryOptions { search_scale, ..Default::default() };
        let error = Trajectory::extract(&strip, &options).expect_err("not a scale").to_string();
        assert!(error.starts_with("search_scale is "), "{error}");
    }
}

#[test]
fn looking_up_and_resampling() {
    let trajectory = Trajectory::from_colors(vec![gray(0.0), gray(0.5), [1.0, 0.5, 0.0]]).expect("colours in range");
    assert_eq!(trajectory.at(0.0), gray(0.0));
    assert_near(&[trajectory.at(0.25), trajectory.at(0.75)], &[gray(0.25), [0.75, 0.5, 0.25]], 1e-6);
    assert_eq!((trajectory.at(1.0), trajectory.at(9.0)), ([1.0, 0.5, 0.0], [1.0, 0.5, 0.0]));
    assert_eq!((trajectory.at(-9.0), trajectory.at(f32::NAN)), (gray(0.0), gray(0.0)));
    assert_eq!(trajectory.resampled(3).expect("a length"), trajectory);
    assert_eq!(trajectory.resampled(1).expect("a length").colors(), [gray(0.5)]);
    let fine = trajectory.resampled(5).expect("a length");
    assert_near(fine.colors(), &[gray(0.0), gray(0.25), gray(0.5), [0.75, 0.5, 0.25], [1.0, 0.5, 0.0]], 1e-6);
}

#[test]
fn table_of_a_trajectory() {
    let trajectory = Trajectory::from_colors(vec![gray(0.0), [0.25, 0.5, 1.0], gray(1.0)]).expect("colours in range");
    assert_eq!(trajectory.to_csv(), "s,r,g,b\n0,0,0,0\n0.5,0.25,0.5,1\n1,1,1,1\n");
}
