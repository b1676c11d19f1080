//! Equation 3.1 and its mean over several lights.

use impasto::scene::{Camera, DirectionalLight, Framing, Lights, Vec3, MAX_LIGHTS};

fn light(x: f32, y: f32, z: f32, intensity: f32) -> DirectionalLight {
    DirectionalLight::new(Vec3::new(x, y, z), intensity).expect("a usable light")
}

#[test]
fn one_light_is_equation_3_1() {
    let lights = Lights::from(light(0.0, 3.0, 0.0, 7.0));
    let cases = [
        (Vec3::Y, 1.0),
        (-Vec3::Y, 0.0),
        (Vec3::X, 0.5),
        // 60 degrees: (1 + 1/2) / 2.
        (Vec3::new(0.866_025_4, 0.5, 0.0), 0.75),
        // A 3-4-5 triangle: (1 - 3/5) / 2.
        (Vec3::new(0.8, -0.6, 0.0), 0.2),
    ];
    for (normal, shade) in cases {
        assert!((lights.shade(normal) - shade).abs() < 1e-6, "{normal}: {}", lights.shade(normal));
    }
}

#[test]
fn several_lights_are_their_weighted_mean() {
    let lights = Lights::new([light(1.0, 0.0, 0.0, 1.0), light(0.0, 2.0, 0.0, 3.0)]).expect("two lights");
    // (1 * 1 + 3 * 1/2) / 4, (1 * 1/2 + 3 * 1) / 4, (1 * 0 + 3 * 1/2) / 4
    assert_eq!(lights.shade(Vec3::X), 0.625);
    assert_eq!(lights.shade(Vec3::Y), 0.875);
    assert_eq!(lights.shade(-Vec3::X), 0.375);
    assert_eq!(lights.mean_direction(), Vec3::new(0.25, 0.75, 0.0));
}

#[test]
fn the_mean_direction_says_the_same_as_the_single_lights() {
    let lights: Vec<_> = (0..MAX_LIGHTS as i32)
        .map(|i| light((i * 7 % 5 - 2) as f32, (i * 3 % 7 - 3) as f32 + 0.5, (i - 4) as f32, 0.1 + i as f32))
        .collect();
    let lights = Lights::new(lights).expect("eight lights");
    for i in 0..100 {
        let angle = i as f32;
        let normal = Vec3::new(angle.sin() * (2.0 * angle).cos(), angle.sin() * (2.0 * angle).sin(), angle.cos());
        let shade = (1.0 + normal.dot(lights.mean_direction())) / 2.0;
        assert!((shade - lights.shade(normal)).abs() < 1e-5);
        assert!((0.0..=1.0).contains(&lights.shade(normal)));
    }
}

#[test]
fn the_default_light_uses_nearly_all_shades_of_a_sphere() {
    let triangle = crate::mesh("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let three_quarter = Camera::framing(&triangle, &Framing::default(), 1.0).expect("a camera");
    for (towards_viewer, darkest) in [(Vec3::Z, 0.04), (-three_quarter.forward(), 0.01)] {
        let (mut low, mut high) = (1.0_f32, 0.0_f32);
        for i in 0..20_000_i32 {
            // Points spread evenly over the sphere along a spiral.
            let z = 1.0 - (i as f32 + 0.5) / 10_000.0;
            let (sin, cos) = (i as f32 * 2.399_963).sin_cos();
            let radius = (1.0 - z * z).sqrt();
            let normal = Vec3::new(radius * cos, radius * sin, z);
            if normal.dot(towards_viewer) >= 0.0 {
                let shade = Lights::default().shade(normal);
                (low, high) = (low.min(shade), high.max(shade));
            }
        }
        assert!(low < darkest && high > 0.999, "{low} to {high}");
    }
}

#[test]
fn a_light_given_in_the_view_keeps_its_place_in_the_picture() {
    let camera = Camera::look_at(Vec3::new(5.0, 0.0, 0.0), Vec3::ZERO, None, 40.0).expect("a camera");
    // Seen from +x, the right of the picture is -z.
    let light = DirectionalLight::from_view(&camera, Vec3::new(2.0, 0.0, 0.0), 1.0).expect("a light");
    assert!(light.direction().distance(-Vec3::Z) < 1e-6);
    let light = DirectionalLight::from_view(&camera, Vec3::Z, 1.0).expect("a light");
    assert!(light.direction().distance(Vec3::X) < 1e-6);
}

#[test]
fn unusable_lights_are_refused() {
    for direction in [Vec3::ZERO, Vec3::NAN, Vec3::new(f32::INFINITY, 0.0, 0.0)] {
        assert!(DirectionalLight::new(direction, 1.0).is_err(), "{direction}");
    }
    for intensity in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert!(DirectionalLight::new(Vec3::X, intensity).is_err(), "{intensity}");
    }
    let error = Lights::new([]).expect_err("no light").to_string();
    assert_eq!(error, "lights is 0, but must be from 1 to 8");
    assert!(Lights::new(vec![light(1.0, 0.0, 0.0, 1.0); MAX_LIGHTS + 1]).is_err());
    // Very short and very long directions are directions all the same.
    assert_eq!(light(1e-30, 0.0, 0.0, 1.0).direction(), Vec3::X);
    assert_eq!(light(0.0, 1e30, 0.0, 1.0).direction(), Vec3::Y);
}
