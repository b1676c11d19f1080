//! Principal components: the directions in which vectors extend most. Numbers alone; [`super::strips`] says of what.

/// Rounds of subspace iteration.
const ROUNDS: usize = 3;
/// Positions that are worked on together.
pub(super) const LANES: usize = 8;

/// The inner loop of all that takes time: adds up four numbers times eight numbers.
#[inline(always)]
pub(super) fn sum_of_products<'a>(terms: impl Iterator<Item = (&'a [f32; 4], &'a [f32; LANES])>) -> [[f32; LANES]; 4] {
    let mut sums = [[0.0; LANES]; 4];
    for (four, eight) in terms {
        for (sums, a) in sums.iter_mut().zip(four) {
            for (sum, b) in sums.iter_mut().zip(eight) {
                *sum += a * b;
            }
        }
    }
    sums
}

/// A matrix, row by row.
pub(super) struct Matrix {
    pub(super) columns: usize,
    pub(super) numbers: Vec<f32>,
}

impl Matrix {
    pub(super) fn new(rows: usize, columns: usize, number: impl Fn(usize, usize) -> f32) -> Self {
        Matrix { columns, numbers: (0..rows * columns).map(|i| number(i / columns, i % columns)).collect() }
    }

    pub(super) fn rows(&self) -> usize {
        self.numbers.len() / self.columns
    }

    pub(super) fn at(&self, row: usize, column: usize) -> f32 {
        self.numbers[row * self.columns + column]
    }

    pub(super) fn transposed(&self) -> Self {
        Matrix::new(self.columns, self.rows(), |row, column| self.at(column, row))
    }

    /// This matrix, transposed, times another of as many rows. It has 4 n columns, the other [`LANES`] n.
    pub(super) fn transposed_times(&self, other: &Matrix) -> Self {
        let mut product = Matrix::new(self.columns, other.columns, |_, _| 0.0);
        for row in (0..self.columns).step_by(4) {
            for column in (0..other.columns).step_by(LANES) {
                let fours = self.numbers.chunks_exact(self.columns).filter_map(|r| r[row..].first_chunk());
                let eights = other.numbers.chunks_exact(other.columns).filter_map(|r| r[column..].first_chunk());
                let sums = sum_of_products(fours.zip(eights));
                for (sums, row) in sums.iter().zip(product.numbers[row * other.columns..].chunks_mut(other.columns)) {
                    row[column..column + LANES].copy_from_slice(sums);
                }
            }
        }
        product
    }
}

/// At most `count` orthonormal directions in which vectors, one in a row, extend most.
///
/// Subspace iteration (G. Golub and C. Van Loan, "Matrix Computations", 7.3.2), which starts from some of the vectors
/// and carries a few directions more than are wanted.
/// Also tells how much of the vectors' squared lengths the first, the first two ... of the directions hold.
pub(super) fn principal_directions(vectors: &Matrix, count: usize) -> (Vec<Vec<f64>>, Vec<f64>) {
    let carried = (count + 8).next_multiple_of(LANES);
    let transposed = vectors.transposed();
    let mut directions = Matrix::new(vectors.columns, carried, |i, n| vectors.at(n * vectors.rows() / carried, i));
    let mut found = Vec::new();
    for _ in 0..ROUNDS {
        let lengths = transposed.transposed_times(&directions);
        directions = vectors.transposed_times(&lengths);
        let column = |n: usize| (0..vectors.columns).map(|i| f64::from(directions.at(i, n))).collect();
        found = orthonormal((0..carried).map(column).collect());
        directions = Matrix::new(vectors.columns, carried, |i, n| found.get(n).map_or(0.0, |found| found[i] as f32));
    }
    found.truncate(count);
    let lengths = transposed.transposed_times(&directions);
    let held = (0..found.len()).scan(0.0, |held, n| {
        *held += (0..lengths.rows()).map(|i| f64::from(lengths.at(i, n)).powi(2)).sum::<f64>();
        Some(*held)
    });
    let held = held.collect();
    (found, held)
}

/// Makes vectors orthonormal, in their order, and leaves out those that depend on the ones before. Gram and Schmidt,
/// twice, which is as exact as the numbers are.
fn orthonormal(vectors: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let dot = |a: &[f64], b: &[f64]| {
        let mut sums = [0.0; 4];
        for (a, b) in a.chunks_exact(4).zip(b.chunks_exact(4)) {
            for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
                *sum += a * b;
            }
        }
        sums.iter().sum::<f64>()
    };
    let mut found: Vec<Vec<f64>> = Vec::new();
    for mut vector in vectors {
        let before = dot(&vector, &vector);
        for _ in 0..2 {
            for other in &found {
                let along = dot(&vector, other);
                vector.iter_mut().zip(other).for_each(|(v, o)| *v -= along * o);
            }
        }
        let after = dot(&vector, &vector);
        // What is left of others is f32's rounding.
        if after > 1e-10 * before {
            let length = after.sqrt();
            vector.iter_mut().for_each(|v| *v /= length);
            found.push(vector);
        }
    }
    found
}

/// Eigenvalues and orthonormal eigenvectors of a symmetric matrix, the largest first, by Jacobi's rotations.
pub(super) fn symmetric_axes(mut a: [[f64; 3]; 3]) -> [(f64, [f64; 3]); 3] {
    let mut axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for _ in 0..16 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let (sin, cos) = (0.5 * (2.0 * a[p][q]).atan2(a[p][p] - a[q][q])).sin_cos();
            let rotated = |u: f64, v: f64| (cos * u + sin * v, cos * v - sin * u);
            for row in &mut a {
                (row[p], row[q]) = rotated(row[p], row[q]);
            }
            for i in 0..3 {
                (a[p][i], a[q][i]) = rotated(a[p][i], a[q][i]);
                (axes[p][i], axes[q][i]) = rotated(axes[p][i], axes[q][i]);
            }
        }
    }
    let mut found = [0, 1, 2].map(|i| (a[i][i], axes[i]));
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found
}
