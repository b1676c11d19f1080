//! A strip's texture that repeats from top to bottom, for techniques that lay it on a model many times over.

use super::separation::TextureDifference;

impl TextureDifference {
    /// The texture with a sixth of its rows less, whose last row goes on in its first one.
    ///
    /// The first rows are laid over the last ones, and each column changes from these to those where a minimum-error
    /// cut passes: the path from left to right with the least sum of squared differences, of equal ones the uppermost
    /// (Efros and Freeman 2001; thesis 3.2.2). Every value stays in its column. A texture whose last row differs from
    /// its first one no more than any two rows beside each other repeats already and stays as it is, as does one of
    /// fewer than 3 rows.
    pub fn tileable_rows(&self) -> TextureDifference {
        let (width, height) = (self.width() as usize, self.height() as usize);
        let pixels = self.pixels();
        let change = |a: usize, b: usize| -> f64 {
            let (a, b) = (&pixels[a * width..(a + 1) * width], &pixels[b * width..(b + 1) * width]);
            a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| f64::from(a - b).powi(2)).sum()
        };
        let inside = (1..height).map(|row| change(row - 1, row)).fold(0.0, f64::max);
        if height < 3 || change(height - 1, 0) <= inside {
            return self.clone();
        }
        let overlap = (height / 6).max(1);
        let kept = height - overlap;
        let error = |x: usize, row: usize| -> f64 {
            let (first, last) = (pixels[row * width + x], pixels[(kept + row) * width + x]);
            first.iter().zip(last).map(|(a, b)| f64::from(a - b).powi(2)).sum()
        };
        // The least error of a path to each row of each column.
        let mut sums = vec![0.0; width * overlap];
        for x in 0..width {
            for row in 0..overlap {
                let before =
                    (row.saturating_sub(1)..(row + 2).min(overlap)).map(|r| sums[(x.max(1) - 1) * overlap + r]);
                let least = if x == 0 { 0.0 } else { before.fold(f64::INFINITY, f64::min) };
                sums[x * overlap + row] = error(x, row) + least;
            }
        }
        let mut cut = vec![0; width];
        let (mut low, mut high) = (0, overlap);
        for x in (0..width).rev() {
            let best =
                (low..high).fold(
                    low,
                    |best, row| {
                        if sums[x * overlap + row] < sums[x * overlap + best] {
                            row
                        } else {
                            best
                        }
                    },
                );
            cut[x] = best;
            (low, high) = (best.saturating_sub(1), (best + 2).min(overlap));
        }
        let mut rows = pixels[..kept * width].to_vec();
        for (x, &cut) in cut.iter().enumerate() {
            // Above the cut the last rows go on from the end of the texture.
            for row in 0..cut {
                rows[row * width + x] = pixels[(kept + row) * width + x];
            }
        }
        TextureDifference::from_parts(self.width(), kept as u32, rows)
    }
}
