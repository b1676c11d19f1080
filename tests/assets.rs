//! The files in `assets/`: they are what the code of the example `make_assets` makes, and what their README says.

use glam::DVec3;
use std::collections::HashMap;
use std::path::PathBuf;

// Not every function of the example is called from here.
#[allow(dead_code)]
#[path = "../examples/make_assets/main.rs"]
mod make_assets;

fn asset(name: &str) -> Vec<u8> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("assets").join(name);
    std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// One `o` block of an OBJ file, its indices counted from its own first vertex.
#[derive(Clone, Default)]
struct Object {
    name: String,
    positions: Vec<DVec3>,
    triangles: Vec<[usize; 3]>,
}

/// Reads the few kinds of lines that our OBJ files have; anything else is an error.
fn objects(text: &str) -> Vec<Object> {
    let mut objects: Vec<Object> = Vec::new();
    let mut first = 1;
    for line in text.lines() {
        let (kind, rest) = line.split_once(' ').expect("a line has a kind");
        let words: Vec<&str> = rest.split(' ').collect();
        if kind == "o" {
            first += objects.last().map_or(0, |o| o.positions.len());
            objects.push(Object { name: rest.to_owned(), ..Object::default() });
        } else if kind != "#" {
            let object = objects.last_mut().expect("vertices belong to an object");
            assert_eq!(words.len(), 3, "{line}");
            match kind {
                "v" => object
                    .positions
                    .push(DVec3::from_slice(&words.iter().map(|w| w.parse().unwrap()).collect::<Vec<_>>())),
                "f" => object.triangles.push(std::array::from_fn(|k| words[k].parse::<usize>().unwrap() - first)),
                _ => panic!("unexpected line: {line}"),
            }
        }
    }
    objects
}

impl Object {
    fn corners(&self, t: &[usize; 3]) -> [DVec3; 3] {
        t.map(|i| self.positions[i])
    }

    /// Whether every edge is used exactly once in either direction: a closed surface, wound in one sense throughout.
    fn is_closed(&self) -> bool {
        let mut uses: HashMap<(usize, usize), u32> = HashMap::new();
        for t in &self.triangles {
            (0..3).for_each(|k| *uses.entry((t[k], t[(k + 1) % 3])).or_default() += 1);
        }
        uses.iter().all(|(&(a, b), &n)| n == 1 && uses.get(&(b, a)) == Some(&1))
    }

    /// Signed volume by the divergence theorem: positive where the triangles face outwards.
    fn volume(&self) -> f64 {
        self.triangles.iter().map(|t| self.corners(t)).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
    }

    /// The connected pieces, each as an object of its own.
    fn pieces(&self) -> Vec<Object> {
        let mut label: Vec<usize> = (0..self.positions.len()).collect();
        loop {
            let before = label.clone();
            for t in &self.triangles {
                let least = t.iter().map(|&i| label[i]).min().unwrap_or(0);
                t.iter().for_each(|&i| label[i] = least);
            }
            if label == before {
                break;
            }
        }
        let mut roots = label.clone();
        roots.sort_unstable();
        roots.dedup();
        let part = |root| Object {
            triangles: self.triangles.iter().copied().filter(|t| label[t[0]] == root).collect(),
            ..self.clone()
        };
        roots.into_iter().map(part).collect()
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        self.positions.iter().fold(start, |(low, high), &p| (low.min(p), high.max(p)))
    }

    /// Twice the area over the squared longest side, of the worst triangle: 0.87 where it is even, 0 where it is flat.
    fn worst_shape(&self) -> f64 {
        let shape = |[a, b, c]: [DVec3; 3]| {
            let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
            (b - a).cross(c - a).length() / longest
        };
        self.triangles.iter().map(|t| shape(self.corners(t))).fold(f64::INFINITY, f64::min)
    }
}

#[test]
fn the_head_is_one_closed_skull_sized_surface() {
    let bytes = asset("head.obj");
    assert!(bytes.len() < 700 * 1024);
    let objects = objects(std::str::from_utf8(&bytes).unwrap());
    assert_eq!(objects.len(), 1);
    let head = &objects[0];
    assert_eq!(head.name, "head");
    assert!((12_000..=20_000).contains(&head.triangles.len()), "{}", head.triangles.len());
    assert!(head.is_closed());
    assert_eq!(head.pieces().len(), 1);
    assert!(head.worst_shape() > 0.02, "{}", head.worst_shape());
    // An ellipsoid of the braincase's size alone holds about 1700 cubic centimetres.
    assert!((1700.0..3000.0).contains(&head.volume()), "{}", head.volume());
    let (low, high) = head.bounds();
    assert!(low.y.abs() < 1e-9 && (20.0..23.0).contains(&high.y));
    assert!((13.0..16.0).contains(&(high.x - low.x)) && (17.0..21.0).contains(&(high.z - low.z)));
    // Mirror symmetry: for each vertex on one side there is surface near its mirror image.
    let nearest = |q: DVec3| head.positions.iter().map(|p| p.distance(q)).fold(f64::INFINITY, f64::min);
    for p in head.positions.iter().step_by(97) {
        let away = nearest(DVec3::new(-p.x, p.y, p.z));
        assert!(away < 0.8, "{p} has nothing opposite within {away}");
    }
}

#[test]
fn the_head_has_eye_sockets_and_a_nose_opening() {
    let head = &objects(std::str::from_utf8(&asset("head.obj")).unwrap())[0];
    // Depth of the frontmost surface on a ray from the front; the chin lies at y = 0, so 9.5 is added to the
    // heights over the ear openings that the model is described in.
    let front = |x: f64, y: f64| {
        let hit = |[a, b, c]: [DVec3; 3]| {
            let (u, v, q) = (b - a, c - a, DVec3::new(x, y, 0.0) - a);
            let det = u.x * v.y - u.y * v.x;
            let (s, t) = ((q.x * v.y - q.y * v.x) / det, (u.x * q.y - u.y * q.x) / det);
            (det > 0.0 && s >= 0.0 && t >= 0.0 && s + t <= 1.0).then_some(a.z + s * u.z + t * v.z)
        };
        head.triangles.iter().filter_map(|t| hit(head.corners(t))).fold(f64::NEG_INFINITY, f64::max)
    };
    let brow = front(2.8, 13.4);
    for side in [-1.0, 1.0] {
        assert!(front(3.0 * side, 11.2) < brow - 3.0, "the eye socket is a deep hollow");
        assert!(front(0.6 * side, 8.2) < brow - 2.5, "so is the nose");
    }
    assert!(front(0.0, 11.0) > brow - 0.5, "the bridge of the nose stands between the eyes");
    assert!(front(0.5, 4.7) > brow - 0.5, "the front teeth stand under the brow");
}

#[test]
fn the_teapot_stands_on_two_triangles() {
    let bytes = asset("teapot_on_table.obj");
    assert!(bytes.len() < 300 * 1024);
    let objects = objects(std::str::from_utf8(&bytes).unwrap());
    assert_eq!(objects.iter().map(|o| o.name.as_str()).collect::<Vec<_>>(), ["teapot", "table"]);
    let (pot, table) = (&objects[0], &objects[1]);
    assert!((4_000..=8_000).contains(&pot.triangles.len()), "{}", pot.triangles.len());
    // Body, lid, handle and spout: each closed and facing outwards.
    assert!(pot.is_closed());
    let pieces = pot.pieces();
    assert_eq!(pieces.len(), 4);
    assert!(pieces.iter().all(|piece| piece.volume() > 0.1));
    assert!(pot.worst_shape() > 0.02, "{}", pot.worst_shape());

    assert_eq!((table.positions.len(), table.triangles.len()), (4, 2));
    for t in &table.triangles {
        let [a, b, c] = table.corners(t);
        assert!((b - a).cross(c - a).y > 0.0, "the table faces up");
    }
    let ((pot_low, pot_high), (low, high)) = (pot.bounds(), table.bounds());
    assert_eq!((low.y, high.y, pot_low.y), (0.0, 0.0, 0.0));
    assert!(low.x < pot_low.x && low.z < pot_low.z && high.x > pot_high.x && high.z > pot_high.z);
}

#[test]
fn the_mesh_checks_notice_damage() {
    let pot = &objects(std::str::from_utf8(&asset("teapot_on_table.obj")).unwrap())[0];
    let mut holed = pot.clone();
    holed.triangles.pop();
    assert!(!holed.is_closed());
    let mut flipped = pot.clone();
    flipped.triangles[7].swap(0, 1);
    assert!(!flipped.is_closed());
    let mut inside_out = pot.clone();
    inside_out.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    assert!(inside_out.is_closed() && inside_out.volume() < 0.0);
}

/// What a strip file must look like.
struct Strip {
    name: &'static str,
    /// Mean colours of the first and the last of 32 bands.
    dark: [u8; 3],
    light: [u8; 3],
    /// The channels (0 red, 1 green, 2 blue) from strongest to weakest in the middle.
    order: [usize; 3],
}

const STRIPS: [Strip; 3] = [
    Strip { name: "strip_green_yellow.png", dark: [10, 45, 50], light: [240, 230, 140], order: [1, 0, 2] },
    Strip { name: "strip_dark_red.png", dark: [32, 14, 15], light: [235, 170, 155], order: [0, 2, 1] },
    Strip { name: "strip_red_yellow.png", dark: [50, 12, 18], light: [248, 215, 95], order: [0, 1, 2] },
];

/// Luma (Rec. 601) of a colour in 0..1.
fn luma(c: DVec3) -> f64 {
    c.dot(DVec3::new(0.299, 0.587, 0.114))
}

/// Mean colours of `count` equal bands from left to right.
fn bands(image: &image::RgbImage, count: usize) -> Vec<DVec3> {
    let (width, height) = (image.width() as usize, image.height() as usize);
    let mut sums = vec![DVec3::ZERO; count];
    for (x, _, p) in image.enumerate_pixels() {
        sums[x as usize * count / width] += DVec3::from(p.0.map(|v| f64::from(v) / 255.0));
    }
    sums.into_iter().map(|sum| sum * (count as f64 / (width * height) as f64)).collect()
}

fn rises(bands: &[DVec3]) -> bool {
    bands.windows(2).all(|pair| luma(pair[0]) < luma(pair[1]))
}

#[test]
fn the_strips_go_steadily_from_dark_to_light() {
    for Strip { name, dark, light, order } in STRIPS {
        let bytes = asset(name);
        assert!(bytes.len() < 200 * 1024);
        let image = image::load_from_memory(&bytes).unwrap();
        assert_eq!(image.color(), image::ColorType::Rgb8, "{name}");
        let image = image.to_rgb8();
        assert_eq!(image.dimensions(), (512, 128), "{name}");
        let bands = bands(&image, 32);
        assert!(rises(&bands), "{name}");
        let mut swapped = bands.clone();
        swapped.swap(15, 16);
        assert!(!rises(&swapped), "the check itself");
        for (band, want) in [(bands[0], dark), (bands[31], light)] {
            let want = DVec3::from(want.map(|v| f64::from(v) / 255.0));
            assert!((band - want).abs().max_element() < 0.08, "{name}: {} instead of {want}", band * 255.0);
        }
        // Paint keeps its saturation in the middle, where a plain blend of the ends would turn greyish.
        let middle = bands[15].to_array();
        assert!(middle[order[0]] > middle[order[1]] && middle[order[1]] >= middle[order[2]], "{name}: {middle:?}");
        let blend = (bands[0] + bands[31]) * 0.5;
        let saturation = |c: DVec3| 1.0 - c.min_element() / c.max_element();
        assert!(saturation(bands[15]) > saturation(blend) + 0.2, "{name}");
    }
}

#[test]
fn the_strips_have_the_texture_of_strokes() {
    for Strip { name, .. } in STRIPS {
        let image = image::load_from_memory(&asset(name)).unwrap().to_rgb8();
        let columns = bands(&image, 512);
        let mut sum = 0.0;
        let mut blown = 0;
        for (x, _, p) in image.enumerate_pixels() {
            let colour = DVec3::from(p.0.map(|v| f64::from(v) / 255.0));
            sum += (colour - columns[x as usize]).length_squared() / 3.0;
            blown += usize::from(p.0 == [255; 3]);
        }
        let deviation = (sum / (512.0 * 128.0)).sqrt();
        assert!((0.05..0.12).contains(&deviation), "{name}: {deviation}");
        assert!(blown < 66, "{name}: bare white shows in {blown} pixels");
    }
}

#[test]
fn the_files_are_what_the_code_makes() {
    assert!(asset("teapot_on_table.obj") == make_assets::teapot_obj().into_bytes(), "teapot_on_table.obj");
    for (name, size, pixels, strokes) in make_assets::strips() {
        // PNG bytes depend on the encoder; the pixels do not.
        let stored = image::load_from_memory(&asset(&name)).unwrap().to_rgb8();
        assert_eq!((stored.width() as usize, stored.height() as usize), size);
        assert!(stored.as_raw() == &pixels, "{name}");
        assert!(strokes > 400, "{name}: {strokes} strokes");
    }
    assert!(asset("head.obj") == make_assets::head_obj().into_bytes(), "head.obj");
}
