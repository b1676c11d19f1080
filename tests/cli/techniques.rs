//! render with each technique, and prepare.

use crate::support::Place;
use image::RgbaImage;
use serde_json::Value;

const RENDER: &str = "render scene.obj --paint strip.png --paint floor=other.png --size 96x72 --block 16 --overlap 4";
const TECHNIQUES: [(&str, &str); 4] = [
    ("image", "--k 1"),
    ("object", "--repeats 3 --variation 0.01 --along 1,2,0"),
    ("aligned", "--level-count 4 --level-size 64 --density 1.5"),
    ("dependent", "--k 1"),
];

/// The share of pixels of which a channel is more than `most` off.
fn off(a: &RgbaImage, b: &RgbaImage, most: u8) -> f64 {
    let differ = a.pixels().zip(b.pixels()).filter(|(a, b)| a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > most));
    differ.count() as f64 / f64::from(a.width() * a.height())
}

#[test]
fn techniques_share_shade_colour_and_outline_and_add_texture() {
    let place = Place::new();
    for (name, flags) in TECHNIQUES {
        let line = format!("{RENDER} -o {name}.png --technique {name} {flags} --dump {name} --validate");
        let report = place.json(&line);
        assert_eq!(report["parameters"]["technique"], name);
    }
    let picture = |name: &str, file: &str| place.picture(&format!("{name}/{file}.png"));
    for (name, _) in TECHNIQUES {
        assert!(off(&picture(name, "shade"), &picture("image", "shade"), 1) < 0.001, "{name}: shade");
        // The same colours by shade, at the same pixels, but for how a device draws an outline.
        assert!(off(&picture(name, "color"), &picture("image", "color"), 3) < 0.01, "{name}: colour");
        let (painted, color, texture) =
            (place.picture(&format!("{name}.png")), picture(name, "color"), picture(name, "texture"));
        let mut textured = 0;
        for ((p, c), t) in painted.pixels().zip(color.pixels()).zip(texture.pixels()) {
            assert_eq!((p.0[3], t.0[3]), (c.0[3], c.0[3]), "{name}");
            for k in 0..3 {
                let sum = (f64::from(c.0[k]) + 2.0 * f64::from(t.0[k]) - 255.0).clamp(0.0, 255.0);
                assert!(p.0[3] == 0 || (f64::from(p.0[k]) - sum).abs() <= 2.5, "{name}: {p:?} {c:?} {t:?}");
            }
            textured += usize::from(t.0[3] == 255 && t.0[0].abs_diff(128) > 1);
        }
        assert!(textured > 500, "{name}: {textured} pixels have texture");
    }
    let coverage: Value = serde_json::from_str(&place.text("dependent/coverage.json")).expect("JSON");
    assert_eq!(coverage["faces"], 6);
    let of = |name: &str| coverage[name].as_u64().expect("a number");
    assert_eq!(of("covered") + of("forced"), 6, "{coverage}");
    assert!(of("slices") >= 2 && of("views") == 14 && of("rounds") >= 1);
    assert!(place.path("image/blocks.json").is_file() && !place.path("aligned/blocks.json").exists());
}

#[test]
fn techniques_give_the_same_picture_twice_and_another_with_another_seed() {
    let place = Place::new();
    for (name, flags) in &TECHNIQUES[1..] {
        // On flat faces the paint that is kept does not depend on t.
        let line = format!("{RENDER} --technique {name} {flags} --flat lose");
        place.ok(&format!("{line} -o a.png"));
        place.ok(&format!("{line} -o b.png"));
        place.ok(&format!("{line} -o c.png --seed 9"));
        assert!(place.bytes("a.png") == place.bytes("b.png"), "{name}");
        assert!(place.bytes("a.png") != place.bytes("c.png"), "{name}");
    }
}

#[test]
fn a_prepared_strip_paints_as_the_strip_itself() {
    let place = Place::new();
    let levels = "--level-count 3 --level-size 48 --block 16 --overlap 4";
    place.ok(&format!("prepare strip.png -o strip.ktx2 {levels} --validate"));
    place.ok(&format!("prepare strip.png -o mask.KTX2 {levels} --level-tiling mask"));
    let render = "render scene.obj --size 64x48 --technique aligned";
    place.ok(&format!("{render} --paint strip.png {levels} -o a.png"));
    place.ok(&format!("{render} --paint strip.ktx2 -o b.png"));
    place.ok(&format!("{render} --paint mask.KTX2 -o c.png"));
    assert!(place.bytes("a.png") == place.bytes("b.png"));
    assert!(place.bytes("b.png") != place.bytes("c.png"));
    place.ok(&format!("{render} --paint strip.ktx2 --gradient 0:#c80000,1:#c80000 -o d.png --dump d"));
    assert!(place.picture("d/color.png").pixels().all(|p| p.0[3] == 0 || p.0 == [200, 0, 0, 255]));
    // A part of a file, another file of that name, and levels that do not fit are refused.
    let bytes = place.bytes("strip.ktx2");
    std::fs::write(place.path("half.ktx2"), &bytes[..bytes.len() / 2]).expect("written");
    std::fs::copy(place.path("strip.png"), place.path("png.ktx2")).expect("copied");
    for (file, part) in [("half.ktx2", "half.ktx2"), ("png.ktx2", "png.ktx2"), ("no.ktx2", "no.ktx2")] {
        place.fails(&format!("{render} --paint {file} -o out.png"), 1, &["--paint", part]);
    }
    place.fails(&format!("{render} --paint strip.ktx2 --level-count 4 -o out.png"), 1, &["--level-count", "3 of 48"]);
    place.fails("render scene.obj --paint strip.ktx2 -o out.png", 1, &["strip.ktx2", "--technique aligned"]);
    place.fails("prepare strip.png -o out.png", 1, &["out.png", ".ktx2"]);
    place.fails("prepare missing.png -o out.ktx2", 1, &["missing.png"]);
    place.fails("prepare strip.png -o out.ktx2 --level-count 65", 1, &["--level-count is 65", "1 to 64"]);
    place.fails("prepare strip.png -o out.ktx2 --block 64 --overlap 8", 1, &["strip.png: 96x40", "--block 64"]);
}

#[test]
fn flags_of_the_techniques_are_checked() {
    let place = Place::new();
    std::fs::write(place.path("field.csv"), "0,0,0,1,0,0\n0,1,0,0,1,0\n").expect("written");
    std::fs::write(place.path("bad.csv"), "0,0,0,1,0\n").expect("written");
    let render = "render scene.obj --paint strip.png --size 64x48 --block 16 --overlap 4 -o out.png --technique";
    let cases = [
        ("object --repeats 0", vec!["--repeats is 0", "0.01 to 1000"]),
        ("object --variation 2", vec!["--variation is 2", "0 to 1"]),
        ("object --along 0,0,0", vec!["--along"]),
        ("object --along nowhere", vec!["--along", "nowhere"]),
        ("object --along bad.csv", vec!["bad.csv", "line 1"]),
        ("aligned --level-count 0", vec!["--level-count is 0", "1 to 64"]),
        ("aligned --level-size 5000", vec!["--level-size is 5000", "2048"]),
        ("aligned --density 9", vec!["--density is 9"]),
        ("dependent --view-size 100", vec!["--view-size", "100", "512"]),
        ("dependent --views 0:99", vec!["--pitch is 99"]),
        ("dependent --follow 181", vec!["--follow is 181", "0 to 180"]),
    ];
    for (flags, parts) in cases {
        place.fails(&format!("{render} {flags}"), 1, &parts);
    }
    for flags in ["object --seams x", "aligned --blend x", "dependent --views 1,2", "oil", "aligned --offset 1"] {
        place.fails(&format!("{render} {flags}"), 2, &["invalid value"]);
    }
    place.ok(
        "render scene.obj --paint grid --size 64x48 --technique object --along field.csv --repeat mirror -o grid.png",
    );
    place.ok("render scene.obj --paint strip.png --size 64x48 --block 16 --overlap 4 --technique dependent --views 0:0 -o v.png");
    let opaque = |name: &str| place.picture(name).pixels().filter(|pixel| pixel.0[3] == 255).count();
    assert_eq!(opaque("grid.png"), opaque("v.png"), "one view is enough for a picture without gaps");
}
