//! Made-up textures: of any side, the same on every machine.

pub type Texels = Vec<[u8; 4]>;

/// A texture by its name, of a side in pixels.
pub type Maker = fn(i32) -> Texels;

/// All of them.
pub const TEXTURES: [(&str, Maker); 3] = [("bricks", bricks), ("gravel", gravel), ("brush", brush)];

/// Random numbers (xorshift32).
struct Numbers(u32);

impl Numbers {
    fn below(&mut self, limit: i32) -> i32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        (self.0 % limit as u32) as i32
    }
}

fn texture(side: i32, mut value: impl FnMut(i32, i32) -> [i32; 3]) -> Texels {
    let pixels = (0..side * side).map(|i| value(i % side, i / side));
    pixels.map(|c| [c[0].clamp(0, 255) as u8, c[1].clamp(0, 255) as u8, c[2].clamp(0, 255) as u8, 255]).collect()
}

/// Courses of bricks with mortar between them and a little noise: few positions fit an overlap.
pub fn bricks(side: i32) -> Texels {
    let mut numbers = Numbers(1);
    texture(side, |x, y| {
        let course = y / 16;
        let mortar = y % 16 < 2 || (x + 20 * (course % 2)) % 40 < 2;
        let n = numbers.below(24);
        if mortar {
            [170 + n, 165 + n, 160 + n]
        } else {
            [140 + n + 10 * (course % 3), 60 + n, 45 + n]
        }
    })
}

/// Pebbles of many shades, dark where they meet, with noise: all positions fit about equally badly, so that bounds
/// leave out least.
pub fn gravel(side: i32) -> Texels {
    let mut numbers = Numbers(3);
    let pebbles: Vec<[i32; 3]> =
        (0..side * side / 90).map(|_| [numbers.below(side), numbers.below(side), numbers.below(120)]).collect();
    let mut noise = Numbers(4);
    texture(side, |x, y| {
        // Squared distances, on a torus, of the nearest pebble and of the one after it.
        let (mut nearest, mut next, mut shade) = (i32::MAX, i32::MAX, 0);
        for &[px, py, pebble_shade] in &pebbles {
            let apart = |a: i32, b: i32| (a - b).abs().min(side - (a - b).abs());
            let distance = apart(x, px).pow(2) + apart(y, py).pow(2);
            if distance < nearest {
                (nearest, next, shade) = (distance, nearest, pebble_shade);
            } else {
                next = next.min(distance);
            }
        }
        let from_edge = f64::from(next).sqrt() - f64::from(nearest).sqrt();
        let value = 40 + shade / 2 + (30.0 * from_edge).min(60.0) as i32 + noise.below(30);
        [value + shade / 6, value, value - 10]
    })
}

/// Short slanted strokes of many shades, one over the other: many positions fit about equally well.
pub fn brush(side: i32) -> Texels {
    let mut numbers = Numbers(2);
    let mut pixels = texture(side, |_, _| [120, 90, 60]);
    for _ in 0..side * side / 12 {
        let (x, y, shade, length) =
            (numbers.below(side), numbers.below(side), numbers.below(110), 8 + numbers.below(20));
        for i in 0..length {
            for width in 0..4 {
                let (x, y) = ((x + i).rem_euclid(side), (y + i / 2 + width).rem_euclid(side));
                let value = |base: i32| (base + shade + grain(x, y) % 12) as u8;
                pixels[(y * side + x) as usize] = [value(100), value(50), value(20), 255];
            }
        }
    }
    pixels
}

fn grain(x: i32, y: i32) -> i32 {
    (x * 7919 + y * 104_729) & 0xff
}
