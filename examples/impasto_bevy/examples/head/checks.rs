//! Whether a picture shows paint where it must, and nowhere else.

use impasto_bevy::impasto::paint::PaintSample;
use std::path::Path;

/// Side of the pictures, pixels.
pub const SIZE_PX: u32 = 512;

/// Texels of 8 bits, RGBA, row by row.
pub struct Picture(pub Vec<u8>);

impl Picture {
    fn pixels(&self) -> impl Iterator<Item = [u8; 3]> {
        self.0.chunks_exact(4).map(|p| [p[0], p[1], p[2]])
    }

    pub fn save(&self, path: &Path) -> image::ImageResult<()> {
        image::save_buffer(path, &self.0, SIZE_PX, SIZE_PX, image::ColorType::Rgba8)
    }
}

/// Which colours strips of paint have, roughly: by cells of the colour cube, and those next to them.
pub struct Palette(Vec<bool>);

impl Palette {
    const CELLS: usize = 16;

    pub fn new(strips: &[PaintSample]) -> Self {
        let mut cells = vec![false; Self::CELLS.pow(3)];
        for [r, g, b, _] in strips.iter().flat_map(PaintSample::to_rgba8) {
            let cell = [r, g, b].map(|c| usize::from(c) * Self::CELLS / 256);
            for near in 0..27 {
                let way = [near % 3, near / 3 % 3, near / 9];
                let at = [0, 1, 2].map(|i| (cell[i] + way[i]).saturating_sub(1).min(Self::CELLS - 1));
                cells[Self::index(at)] = true;
            }
        }
        Self(cells)
    }

    fn index([r, g, b]: [usize; 3]) -> usize {
        (r * Self::CELLS + g) * Self::CELLS + b
    }

    fn has(&self, pixel: [u8; 3]) -> bool {
        self.0[Self::index(pixel.map(|c| usize::from(c) * Self::CELLS / 256))]
    }
}

/// Blue, by at least 40: the post before the head.
fn is_front([r, g, b]: [u8; 3]) -> bool {
    b > r.max(g).saturating_add(40)
}

/// Red, by at least 40: the post behind it.
fn is_back([r, g, b]: [u8; 3]) -> bool {
    r > g.max(b).saturating_add(40)
}

/// What is wrong with a painted picture, given the same one without what is painted.
pub fn faults(plain: &Picture, painted: &Picture, palette: &Palette, angle: usize) -> Vec<String> {
    let before: Vec<_> = plain.pixels().collect();
    let after: Vec<_> = painted.pixels().collect();
    let changed: Vec<bool> = before.iter().zip(&after).map(|(a, b)| a != b).collect();
    let count = |what: &dyn Fn(usize) -> bool| (0..before.len()).filter(|&i| what(i)).count();
    let paint = count(&|i| changed[i]);
    let over_front = count(&|i| changed[i] && is_front(before[i]));
    let over_back = count(&|i| changed[i] && is_back(before[i]));
    // Of the post: with paint to the left and to the right of it.
    let hiding = |row: &[bool], before: &[[u8; 3]]| {
        let (first, last) = (row.iter().position(|c| *c), row.iter().rposition(|c| *c));
        let (Some(first), Some(last)) = (first, last) else { return 0 };
        before[first..last].iter().filter(|p| is_front(**p)).count()
    };
    let side = SIZE_PX as usize;
    let hiding: usize = changed.chunks(side).zip(before.chunks(side)).map(|(c, b)| hiding(c, b)).sum();
    let strange = count(&|i| changed[i] && !palette.has(after[i]));
    let least = before.len() / 20;
    let checks = [
        (paint > least, format!("{paint} pixels are painted")),
        (over_front == 0, format!("{over_front} pixels of the post before the head are painted over")),
        (over_back > 200, format!("{over_back} pixels of the post behind the head are painted over")),
        (hiding > 1000, format!("{hiding} pixels of the post before the head hide paint")),
        (strange * 50 < paint, format!("{strange} painted pixels of {paint} have colours that the paints have not")),
    ];
    checks.into_iter().filter(|(right, _)| !right).map(|(_, what)| format!("view {angle}: {what}")).collect()
}
