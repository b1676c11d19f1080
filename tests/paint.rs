//! The paint room: trajectories against values worked by hand, properties of the separation, real strips.
//! Reading picture files is tested in `paint_files.rs`, the artist's hand-made curves and stops in `paint_curves.rs`.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use impasto::paint::{PaintSample, StripHint, TextureDifference, Timing, Trajectory, TrajectoryOptions};

type Color = [f32; 3];

fn gray(value: f32) -> Color {
    [value; 3]
}

/// A strip of one row: its column means are these very colours.
fn strip(colors: &[Color]) -> PaintSample {
    PaintSample::from_pixels(colors.len() as u32, 1, colors.to_vec()).expect("colours in range")
}

fn extract(strip: &PaintSample, search_scale: f32, timing: Timing) -> Trajectory {
    Trajectory::extract(strip, &TrajectoryOptions { search_scale, timing, speed: None }).expect("a fair scale")
}

fn kept(colors: &[Color], search_scale: f32) -> Vec<u32> {
    extract(&strip(colors), search_scale, Timing::Stretch).kept_columns().to_vec()
}

fn assert_near(a: &[Color], b: &[Color], tolerance: f32) {
    assert_eq!(a.len(), b.len());
    for (index, (a, b)) in a.iter().zip(b).enumerate() {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= tolerance), "colour {index}: {a:?} but {b:?}");
    }
}

/// Repeatable noise in 0..1 (xorshift, G. Marsaglia 2003).
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }

    fn color(&mut self) -> Color {
        [self.next(), self.next(), self.next()]
    }
}

// The recursion of section 4.1, by hand.

#[test]
fn recursion_sorts_colours_on_a_line() {
    let colors = [0.0, 0.75, 0.25, 0.5, 1.0].map(gray);
    assert_eq!(kept(&colors, 1.0), [0, 2, 3, 1, 4]);
}

#[test]
fn recursion_drops_what_is_outside_the_sphere() {
    // A, then 0.6 away from the midpoint M = (0.5, 0, 0), then B: the radius is 0.5 times the scale.
    let colors = [[0.0, 0.0, 0.0], [0.5, 0.6, 0.0], [1.0, 0.0, 0.0]];
    assert_eq!(kept(&colors, 1.0), [0, 2]);
    assert_eq!(kept(&colors, 1.19), [0, 2]);
    assert_eq!(kept(&colors, 1.21), [0, 1, 2]);
    // On the sphere itself counts as contained.
    let colors = [[0.0, 0.0, 0.0], [0.5, 0.5, 0.0], [1.0, 0.0, 0.0]];
    assert_eq!(kept(&colors, 1.0), [0, 1, 2]);
    assert_eq!(kept(&colors, 0.99), [0, 2]);
}

#[test]
fn recursion_takes_the_colour_nearest_to_the_midpoint() {
    // M = (0.5, 0, 0). Column 2 (0.1 from M) enters before column 1 (0.4 from M). Of the spheres that are left, that
    // of A and column 2 (centre (0.25, 0, 0.05), radius 0.255) does not hold column 1, nor does the other one. Had
    // column 1 entered first, it would be there.
    let colors = [[0.0, 0.0, 0.0], [0.5, 0.4, 0.0], [0.5, 0.0, 0.1], [1.0, 0.0, 0.0]];
    assert_eq!(kept(&colors, 1.0), [0, 2, 3]);
}

#[test]
fn ties_go_to_the_lowest_column() {
    // Columns 1 and 2 are 0.25 from M; each is outside of the spheres that the other one leaves.
    let colors = [[0.0, 0.0, 0.0], [0.5, 0.25, 0.0], [0.5, 0.0, 0.25], [1.0, 0.0, 0.0]];
    assert_eq!(kept(&colors, 1.0), [0, 1, 3]);
}

#[test]
fn scale_zero_keeps_the_ends_alone() {
    let trajectory = extract(&strip(&[0.0, 0.3, 0.9, 1.0].map(gray)), 0.0, Timing::Stretch);
    assert_eq!(trajectory.kept_columns(), [0, 3]);
    assert_near(trajectory.colors(), &[0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0].map(gray), 1e-6);
}

#[test]
fn equal_colours_stay_in_the_order_of_the_strip() {
    let colors = [0.0, 0.0, 0.0, 0.5, 0.5, 1.0, 1.0].map(gray);
    assert_eq!(kept(&colors, 1.0), [0, 1, 2, 3, 4, 5, 6]);
}

#[test]
fn every_column_enters_at_most_once_and_any_factor_ends() {
    let mut noise = Noise(7);
    let colors: Vec<Color> = (0..300).map(|_| noise.color()).collect();
    for scale in [0.0, 0.5, 1.0, 1.25, 2.0, 10.0, f32::MAX] {
        let path = kept(&colors, scale);
        assert_eq!((path.first(), path.last()), (Some(&0), Some(&299)));
        let mut sorted = path.clone();
        sorted.sort_unstable();
        sorted.dedup();
        assert_eq!(sorted.len(), path.len(), "scale {scale}");
    }
    assert_eq!(kept(&colors, f32::MAX).len(), 300);
}

#[test]
fn stretch_interpolates_the_kept_colours_evenly() {
    // Column 1 is dropped, so three kept colours are stretched over four columns.
    let colors = [[0.0, 0.0, 0.0], [0.2, 0.9, 0.0], [0.6, 0.0, 0.0], [1.0, 0.0, 0.0]];
    let trajectory = extract(&strip(&colors), 1.0, Timing::Stretch);
    assert_eq!(trajectory.kept_columns(), [0, 2, 3]);
    let expected = [[0.0, 0.0, 0.0], [0.4, 0.0, 0.0], [0.6 + 0.4 / 3.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
    assert_near(trajectory.colors(), &expected, 1e-6);
}

// Timing.

#[test]
fn a_clean_ramp_is_its_own_trajectory() {
    for width in [2, 3, 7, 64, 512, 700, 1025] {
        let ramp: Vec<Color> = (0..width).map(|i| i as f32 / (width - 1) as f32).map(|v| [v, v * 0.5, 0.25]).collect();
        for timing in [Timing::Fit, Timing::Stretch] {
            assert_near(extract(&strip(&ramp), 1.0, timing).colors(), &ramp, 1e-5);
        }
    }
}

#[test]
fn fit_puts_colours_back_where_the_strip_has_them() {
    // The right half alternates in blue beyond any sphere, and loses its colours: the stretch gives their columns to
    // the left half, the fit must not.
    let width = 400;
    let value = |i: usize| i as f32 / (width - 1) as f32;
    let blue = |i: usize| if i > width / 2 && i < width - 1 { [0.1, 0.9][i % 2] } else { 0.5 };
    let colors: Vec<Color> = (0..width).map(|i| [value(i), value(i), blue(i)]).collect();
    let strip = strip(&colors);
    let (fit, stretch) = (extract(&strip, 1.0, Timing::Fit), extract(&strip, 1.0, Timing::Stretch));
    assert!(fit.kept_columns().len() < width * 3 / 4);
    let deviation =
        |trajectory: &Trajectory| (0..width).map(|i| (trajectory.colors()[i][0] - value(i)).abs()).fold(0.0, f32::max);
    assert!(deviation(&stretch) > 0.2, "{}", deviation(&stretch));
    assert!(deviation(&fit) < 0.02, "{}", deviation(&fit));
    assert!(fit.residual(&strip).rms < 0.1 * stretch.residual(&strip).rms);
}

#[test]
fn fit_keeps_the_ends_and_never_turns_back() {
    let mut noise = Noise(11);
    let colors: Vec<Color> =
        (0..257).map(|i| gray((i as f32 / 256.0 + 0.2 * (noise.next() - 0.5)).clamp(0.0, 1.0))).collect();
    let trajectory = extract(&strip(&colors), 1.0, Timing::Fit);
    assert_eq!((trajectory.colors()[0], trajectory.colors()[256]), (colors[0], colors[256]));
    assert!(trajectory.colors().windows(2).all(|pair| pair[1][0] >= pair[0][0]));
}

#[test]
fn a_gap_in_the_path_becomes_a_ramp() {
    // Two tones and nothing between them: the fit passes from one to the other over several columns.
    let colors: Vec<Color> = (0..200).map(|i| if i < 100 { gray(0.2) } else { gray(0.8) }).collect();
    let trajectory = extract(&strip(&colors), 1.0, Timing::Fit);
    let hop = trajectory.colors().windows(2).map(|pair| pair[1][0] - pair[0][0]).fold(0.0, f32::max);
    assert!(hop < 0.1, "{hop}");
    assert_near(&trajectory.colors()[80..81], &[gray(0.2)], 0.01);
    assert_near(&trajectory.colors()[119..120], &[gray(0.8)], 0.01);
}

#[test]
fn even_stretches_of_a_strip_stay_where_they_are() {
    // Hardly any change for a long time, then a dash to the end; the noise tells the columns of the first part apart.
    let mut noise = Noise(23);
    let clean = |i: usize| 0.3 + 0.7 * i.saturating_sub(400) as f32 / 111.0;
    let colors: Vec<Color> =
        (0..512).map(|i| gray((clean(i) + 0.004 * (noise.next() - 0.5)).clamp(0.0, 1.0))).collect();
    let fit = extract(&strip(&colors), 1.0, Timing::Fit);
    let expected: Vec<Color> = (0..512).map(|i| gray(clean(i))).collect();
    assert_near(&fit.colors()[..350], &expected[..350], 0.003);
    // The corner is rounded, by about eight columns' worth of the dash.
    assert_near(fit.colors(), &expected, 0.06);
}

#[test]
fn fit_crosses_a_dark_band_smoothly() {
    // A ramp with a deep dark band: the path cannot go back, so it lingers, but it must not stop dead and start again.
    let value = |i: usize| i as f32 / 399.0 - if (150..250).contains(&i) { 0.3 } else { 0.0 };
    let colors: Vec<Color> = (0..400).map(|i| gray(value(i).max(0.0))).collect();
    let fit = extract(&strip(&colors), 1.0, Timing::Fit);
    let bend = fit.colors().windows(3).map(|w| (w[0][0] - 2.0 * w[1][0] + w[2][0]).abs()).fold(0.0, f32::max);
    assert!(bend < 0.004, "{bend}");
}

#[test]
fn residual_is_measured_in_units_of_the_colour_range() {
    // An even strip at 0.5; the trajectory is off by 0.1 in red everywhere and by 0.3 in its last colour.
    let strip = strip(&[gray(0.5); 4]);
    let colors = vec![[0.6, 0.5, 0.5], [0.6, 0.5, 0.5], [0.6, 0.5, 0.5], [0.8, 0.5, 0.5]];
    let residual = Trajectory::from_colors(colors).expect("colours in range").residual(&strip);
    assert!((residual.max - 0.3).abs() < 1e-6);
    // sqrt((3 * 0.01 + 0.09) / 12) = 0.1
    assert!((residual.rms - 0.1).abs() < 1e-6);
}

// Degenerate strips.

#[test]
fn constant_strip_gives_a_constant_trajectory_and_no_difference() {
    let color = [0.3, 0.6, 0.1];
    for (width, height) in [(1, 1), (1, 9), (2, 3), (50, 7), (513, 2)] {
        let strip =
            PaintSample::from_pixels(width, height, vec![color; (width * height) as usize]).expect("sizes match");
        for timing in [Timing::Fit, Timing::Stretch] {
            let trajectory = extract(&strip, 1.0, timing);
            assert_eq!(trajectory.colors(), vec![color; width as usize]);
            let difference = TextureDifference::extract(&strip, &trajectory);
            assert!(difference.pixels().iter().all(|&pixel| pixel == [0.0; 3]));
            assert!(trajectory.residual(&strip).max < 1e-6);
        }
    }
}

#[test]
fn strips_of_one_and_two_columns_are_their_column_means() {
    let one = PaintSample::from_pixels(1, 2, vec![gray(0.25), gray(0.75)]).expect("sizes match");
    assert_eq!(extract(&one, 1.0, Timing::Fit).colors(), [gray(0.5)]);
    let two = strip(&[gray(0.25), [1.0, 0.0, 0.5]]);
    assert_eq!(extract(&two, 1.0, Timing::Fit).colors(), [gray(0.25), [1.0, 0.0, 0.5]]);
}

#[test]
fn a_strip_that_ends_in_its_first_colour_is_followed_there_and_back() {
    // Dark, light, dark; and once round in colour space. Half of that is just what the plain search area holds.
    let there_and_back: Vec<Color> = (0..201).map(|i| gray(1.0 - (i as f32 - 100.0).abs() / 100.0)).collect();
    let round: Vec<Color> = (0..240)
        .map(|i| (i as f32 / 239.0 * std::f32::consts::TAU).sin_cos())
        .map(|(sine, cosine)| [0.5 + 0.4 * cosine, 0.5 + 0.4 * sine, 0.5])
        .collect();
    for (colors, search_scale) in [(there_and_back, 1.0), (round, 1.1)] {
        let strip = strip(&colors);
        for timing in [Timing::Fit, Timing::Stretch] {
            let residual = extract(&strip, search_scale, timing).residual(&strip);
            assert!(residual.rms < 0.02 && residual.max < 0.06, "{timing:?} {residual:?}");
        }
    }
}

#[test]
fn a_wide_strip_takes_bounded_time() {
    let mut noise = Noise(3);
    let random: Vec<Color> = (0..4096).map(|_| noise.color()).collect();
    let constant = vec![gray(0.5); 4096];
    for colors in [random, constant] {
        for scale in [1.0, 2.0, 1e30] {
            let start = Instant::now();
            assert_eq!(extract(&strip(&colors), scale, Timing::Fit).len(), 4096);
            // 0.1 s in an optimised build on one core; this guards against growth with the cube, not against noise.
            assert!(start.elapsed() < Duration::from_secs(20), "scale {scale}: {:?}", start.elapsed());
        }
    }
}

// Separation, section 4.2.

#[test]
fn difference_and_clipping_by_hand() {
    let rows = vec![gray(0.2), gray(0.9), gray(0.6), gray(0.5)];
    let sample = PaintSample::from_pixels(2, 2, rows).expect("sizes match");
    let own = Trajectory::from_colors(vec![gray(0.4), gray(0.7)]).expect("colours in range");
    let difference = TextureDifference::extract(&sample, &own);
    assert_near(difference.pixels(), &[-0.2, 0.2, 0.2, -0.2].map(gray), 1e-6);
    let other = Trajectory::from_colors(vec![gray(0.1), gray(0.95)]).expect("colours in range");
    assert_near(difference.recombine(&other).pixels(), &[0.0, 1.0, 0.3, 0.75].map(gray), 1e-6);
}

#[test]
fn trajectories_of_another_length_are_resampled() {
    let sample = PaintSample::from_pixels(3, 1, vec![gray(0.5); 3]).expect("sizes match");
    let short = Trajectory::from_colors(vec![gray(0.0), gray(1.0)]).expect("colours in range");
    let difference = TextureDifference::extract(&sample, &short);
    assert_near(difference.pixels(), &[0.5, 0.0, -0.5].map(gray), 1e-6);
    assert_near(difference.recombine(&short).pixels(), &[0.5, 0.5, 0.5].map(gray), 1e-6);
}

#[test]
fn difference_in_eight_bits() {
    let values = vec![[-1.0, 0.0, 1.0], [-0.5, 0.5, 0.25]];
    let difference = TextureDifference::from_pixels(2, 1, values).expect("sizes match");
    // (d + 1) / 2 * 255: 127.5 rounds up; 63.75, 191.25, 159.375.
    assert_eq!(difference.to_unorm8(), [[0, 128, 255, 255], [64, 191, 159, 255]]);
    assert_eq!(difference.to_image().get_pixel(1, 0).0, [64, 191, 159, 255]);
    assert!(TextureDifference::from_pixels(1, 1, vec![gray(1.01)]).is_err());
    assert!(TextureDifference::from_pixels(1, 1, vec![gray(f32::NAN)]).is_err());
    assert!(TextureDifference::from_pixels(2, 1, vec![gray(0.0)]).is_err());
    assert!(TextureDifference::from_pixels(0, 0, Vec::new()).is_err());
}

#[test]
fn recombining_with_its_own_trajectory_gives_the_sample_back() {
    let mut noise = Noise(5);
    let pixels: Vec<Color> = (0..64 * 9).map(|_| noise.color()).collect();
    let sample = PaintSample::from_pixels(64, 9, pixels).expect("sizes match");
    for trajectory in [extract(&sample, 1.0, Timing::Fit), extract(&sample, 1.5, Timing::Stretch)] {
        let difference = TextureDifference::extract(&sample, &trajectory);
        assert!(difference.pixels().as_flattened().iter().all(|value| value.abs() <= 1.0));
        assert_near(difference.recombine(&trajectory).pixels(), sample.pixels(), 1e-6);
        assert_eq!(difference.recombine(&trajectory).to_rgba8(), sample.to_rgba8());
    }
}

// Whole strips.

#[test]
fn a_strip_laid_wrongly_is_noticed() {
    let ramp = |x: u32, length: u32| gray(x as f32 / (length - 1) as f32);
    let hint = |w: u32, h: u32, color: &dyn Fn(u32, u32) -> Color| {
        let pixels = (0..h).flat_map(|y| (0..w).map(move |x| (x, y))).map(|(x, y)| color(x, y)).collect();
        PaintSample::from_pixels(w, h, pixels).expect("sizes match").strip_hint()
    };
    assert_eq!(hint(9, 4, &|x, _| ramp(x, 9)), None);
    assert_eq!(hint(9, 4, &|x, _| ramp(8 - x, 9)), Some(StripHint::LightToDark));
    assert_eq!(hint(4, 9, &|_, y| ramp(y, 9)), Some(StripHint::StoodOnEnd));
    assert_eq!(hint(4, 9, &|_, y| ramp(8 - y, 9)), Some(StripHint::StoodOnEnd));
    assert_eq!(hint(4, 9, &|x, _| ramp(x, 4)), None);
    assert_eq!(hint(9, 4, &|_, y| ramp(y, 4)), None);
    assert_eq!(hint(9, 4, &|_, _| gray(0.5)), None);
    assert_eq!(hint(1, 1, &|_, _| gray(0.5)), None);
}

#[test]
fn real_strips_are_fitted_closely_and_smoothly() {
    let beside = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let folder = std::env::var_os("IMPASTO_DATA").map_or(beside, PathBuf::from);
    if !folder.is_dir() {
        return eprintln!("no sample data, nothing tested");
    }
    let mut rms = Vec::new();
    for entry in std::fs::read_dir(folder.join("paint")).expect("the folder of strips") {
        let path = entry.expect("a folder entry").path();
        if path.extension().is_none_or(|extension| extension != "png") {
            continue;
        }
        let strip = PaintSample::load(&path).expect("a strip");
        assert_eq!(strip.strip_hint(), None, "{}", path.display());
        let (fit, stretch) = (extract(&strip, 1.0, Timing::Fit), extract(&strip, 1.0, Timing::Stretch));
        let (near, far) = (fit.residual(&strip), stretch.residual(&strip));
        assert!(near.rms < far.rms && near.max <= far.max, "{}: {near:?} {far:?}", path.display());
        // Measured: at most 0.027 and 0.114, where a strip starts in a colour that is not its darkest.
        assert!(near.rms < 0.03 && near.max < 0.12, "{}: {near:?}", path.display());
        rms.push(near.rms);
        // No streaks: from column to column the colour bends a fraction as much as the column means do.
        let bend = |colors: &[Color]| -> f32 {
            let channels = |w: &[Color]| (0..3).map(|k| (w[0][k] - 2.0 * w[1][k] + w[2][k]).abs()).sum::<f32>();
            colors.windows(3).map(channels).sum()
        };
        assert!(bend(fit.colors()) < 0.75 * bend(&strip.column_means()), "{}", path.display());
        // A wider search area lets streaks in, but the path holds together.
        let wide = extract(&strip, 1.5, Timing::Fit).residual(&strip);
        assert!(wide.rms < 0.03, "{}: {wide:?}", path.display());
        let difference = TextureDifference::extract(&strip, &fit);
        assert_eq!(difference.recombine(&fit).to_rgba8(), strip.to_rgba8(), "{}", path.display());
    }
    rms.sort_by(f32::total_cmp);
    assert!(rms.len() >= 13 && rms[rms.len() / 2] < 0.007, "{rms:?}");
}
