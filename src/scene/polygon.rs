//! Cutting a polygon into triangles: a fan if it is convex, otherwise ear clipping (Meisters 1975), so that concave
//! faces, and holes that are cut by a doubled edge, are covered once and nothing outside of them is.

/// A point of the polygon's plane.
type Point = [f64; 2];

/// Steps that ear clipping may take for all faces of one model together: seconds, not minutes, on hostile input.
const MAX_STEPS: u64 = 1 << 30;

/// Cuts polygons, within a bound on the work for all of them.
pub(super) struct Triangulator {
    steps_left: u64,
}

impl Default for Triangulator {
    fn default() -> Self {
        Self { steps_left: MAX_STEPS }
    }
}

/// Whether a polygon was cut exactly.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Cut {
    /// Every triangle lies within the polygon.
    Exact,
    /// It crosses itself or is too intricate: the triangles cover it roughly.
    Rough,
}

impl Triangulator {
    /// Cuts the polygon with these corner positions (three or more, all finite); calls `emit` with the corners
    /// (indices into `corners`) of each of its n - 2 triangles, in the polygon's own winding.
    pub fn cut(&mut self, corners: &[[f32; 3]], mut emit: impl FnMut([usize; 3])) -> Cut {
        let n = corners.len();
        if n == 3 {
            emit([0, 1, 2]);
            return Cut::Exact;
        }
        if let &[a, b, c, d] = corners {
            let (cut, triangles) = cut_quad([a, b, c, d]);
            triangles.into_iter().for_each(emit);
            return cut;
        }
        let points = flatten(corners);
        if is_convex(&points) {
            (2..n).for_each(|i| emit([0, i - 1, i]));
            return Cut::Exact;
        }
        self.clip_ears(&points, emit)
    }

    fn clip_ears(&mut self, points: &[Point], mut emit: impl FnMut([usize; 3])) -> Cut {
        let mut ring: Vec<usize> = (0..points.len()).collect();
        let mut cut = Cut::Exact;
        // The corner that is looked at, and how many in a row were no ear.
        let (mut at, mut failed) = (0, 0);
        while ring.len() > 3 && self.steps_left > 0 {
            let n = ring.len();
            let corner = [ring[(at + n - 1) % n], ring[at], ring[(at + 1) % n]];
            // After a round without an ear, a corner without area may go; after another one, any.
            let forced = failed >= 2 * n;
            if forced {
                cut = Cut::Rough;
            }
            if forced || (failed >= n && is_flat(corner.map(|i| points[i]))) || self.is_ear(points, &ring, corner) {
                emit(corner);
                ring.remove(at);
                self.steps_left = self.steps_left.saturating_sub(n as u64 / 8);
                // On with the corner after next, so that the triangles do not all fan out from one corner.
                at = if at == n - 1 { 0 } else { (at + 1) % (n - 1) };
                failed = 0;
            } else {
                at = (at + 1) % n;
                failed += 1;
            }
        }
        if ring.len() > 3 || turn(points[ring[0]], points[ring[1]], points[ring[2]]) < 0.0 {
            cut = Cut::Rough;
        }
        (2..ring.len()).for_each(|i| emit([ring[0], ring[i - 1], ring[i]]));
        cut
    }

    /// True if the corner is convex and no other corner of the ring lies in its triangle, edges included. Corners at
    /// the same place as one of the triangle's do not count: that is how a hole is joined to the outline.
    fn is_ear(&mut self, points: &[Point], ring: &[usize], [a, b, c]: [usize; 3]) -> bool {
        let [a, b, c] = [points[a], points[b], points[c]];
        self.steps_left = self.steps_left.saturating_sub(1);
        if turn(a, b, c) <= 0.0 {
            return false;
        }
        self.steps_left = self.steps_left.saturating_sub(ring.len() as u64);
        !ring
            .iter()
            .map(|&i| points[i])
            .any(|p| p != a && p != b && p != c && turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0)
    }
}

/// Cuts along the diagonal over which the two triangles agree better in direction. In a plane that is the one within
/// the quad; a skew quad, which may well cross itself in any projection, is folded least.
fn cut_quad(corners: [[f32; 3]; 4]) -> (Cut, [[usize; 3]; 2]) {
    let agreement = |cut: [[usize; 3]; 2]| {
        let [p, q] = cut.map(|[a, b, c]| {
            let side = |to: usize| std::array::from_fn(|i| f64::from(corners[to][i]) - f64::from(corners[a][i]));
            cross(side(b), side(c))
        });
        let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
        let lengths = (dot(p, p) * dot(q, q)).sqrt();
        // A triangle without area is better than one on its back, and worse than any other.
        if lengths > 0.0 {
            dot(p, q) / lengths
        } else {
            -0.99
        }
    };
    let [first, second] = [[[0, 1, 2], [0, 2, 3]], [[0, 1, 3], [1, 2, 3]]];
    let [a, b] = [agreement(first), agreement(second)];
    // Where there is nothing to choose, all quads are cut alike.
    let (cut, agreement) = if b > a + 1e-6 { (second, b) } else { (first, a) };
    (if agreement > -0.999 { Cut::Exact } else { Cut::Rough }, cut)
}

/// The corners in the plane that fits the polygon best, counter-clockwise.
fn flatten(corners: &[[f32; 3]]) -> Vec<Point> {
    let corners: Vec<[f64; 3]> = corners.iter().map(|corner| corner.map(f64::from)).collect();
    // Twice the polygon's area as a vector: the sum of the triangles with the first corner.
    let origin = corners[0];
    let normal = corners.windows(2).fold([0.0; 3], |sum: [f64; 3], pair| {
        let [p, q] = [pair[0], pair[1]].map(|corner| std::array::from_fn(|i| corner[i] - origin[i]));
        let cross = cross(p, q);
        std::array::from_fn(|i| sum[i] + cross[i])
    });
    // Leaving out the coordinate in which the normal is longest keeps the shape up to an affine map.
    let axis = (0..3).max_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs())).unwrap_or(2);
    let (mut x, mut y) = ((axis + 1) % 3, (axis + 2) % 3);
    if normal[axis] < 0.0 {
        (x, y) = (y, x);
    }
    corners.iter().map(|corner| [corner[x] - origin[x], corner[y] - origin[y]]).collect()
}

fn cross(p: [f64; 3], q: [f64; 3]) -> [f64; 3] {
    [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
}

/// Twice the signed area of the triangle: positive if it turns counter-clockwise.
fn turn(a: Point, b: Point, c: Point) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// True if the corner is straight or folded back, as far as single precision can tell.
fn is_flat([a, b, c]: [Point; 3]) -> bool {
    let length = |p: Point, q: Point| (q[0] - p[0]).hypot(q[1] - p[1]);
    turn(a, b, c).abs() <= 1e-5 * length(a, b) * length(b, c)
}

/// True if the polygon goes around once and turns left at every corner. A straight corner does not count as convex: a
/// fan would spend it on a triangle without area.
fn is_convex(points: &[Point]) -> bool {
    let n = points.len();
    let edges: Vec<Point> =
        (0..n).map(|i| std::array::from_fn(|axis| points[(i + 1) % n][axis] - points[i][axis])).collect();
    let turns = (0..n).map(|i| {
        let (p, q) = (edges[i], edges[(i + 1) % n]);
        (p[0] * q[1] - p[1] * q[0]).atan2(p[0] * q[0] + p[1] * q[1])
    });
    let mut total = 0.0;
    for turn in turns {
        if turn < 1e-6 {
            return false;
        }
        total += turn;
    }
    (total - std::f64::consts::TAU).abs() < 1e-3
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(points: &[[f32; 3]], triangles: &[[usize; 3]]) -> (f64, bool) {
        let flat: Vec<Point> = points.iter().map(|p| [f64::from(p[0]), f64::from(p[1])]).collect();
        let turns: Vec<f64> = triangles.iter().map(|&[a, b, c]| turn(flat[a], flat[b], flat[c]) / 2.0).collect();
        (turns.iter().sum(), turns.iter().all(|&turn| turn >= 0.0))
    }

    fn cut(points: &[[f32; 3]]) -> (Vec<[usize; 3]>, Cut) {
        let mut triangles = Vec::new();
        let cut = Triangulator::default().cut(points, |triangle| triangles.push(triangle));
        assert_eq!(triangles.len(), points.len() - 2);
        (triangles, cut)
    }

    fn flat(points: &[[f32; 2]]) -> Vec<[f32; 3]> {
        points.iter().map(|&[x, y]| [x, y, 5.0]).collect()
    }

    #[test]
    fn an_arrowhead_is_cut_at_its_notch_wherever_it_starts() {
        let arrow = [[0.0, 0.0], [2.0, -1.0], [1.0, 0.0], [2.0, 1.0]];
        for start in 0..4 {
            let mut arrow = arrow;
            arrow.rotate_left(start);
            let arrow = flat(&arrow);
            let (triangles, outcome) = cut(&arrow);
            assert_eq!(outcome, Cut::Exact);
            assert_eq!(area(&arrow, &triangles), (1.0, true), "start {start}: {triangles:?}");
        }
    }

    #[test]
    fn a_clockwise_polygon_keeps_its_winding() {
        let arrow = flat(&[[2.0, 1.0], [1.0, 0.0], [2.0, -1.0], [0.0, 0.0]]);
        let (triangles, _) = cut(&arrow);
        let (sum, _) = area(&arrow, &triangles);
        assert_eq!(sum, -1.0);
    }

    #[test]
    fn a_hole_joined_by_a_doubled_edge_stays_open() {
        // A 4x4 square with a 2x2 hole, joined from (0,0) to (1,1): area 16 - 4.
        let ring = flat(&[
            [0.0, 0.0],
            [4.0, 0.0],
            [4.0, 4.0],
            [0.0, 4.0],
            [0.0, 0.0],
            [1.0, 1.0],
            [1.0, 3.0],
            [3.0, 3.0],
            [3.0, 1.0],
            [1.0, 1.0],
        ]);
        let (triangles, outcome) = cut(&ring);
        assert_eq!(outcome, Cut::Exact);
        assert_eq!(area(&ring, &triangles), (12.0, true));
    }

    #[test]
    fn a_comb_of_many_teeth_is_covered_exactly() {
        let teeth = 200;
        let mut points = vec![[0.0, -1.0], [2.0 * teeth as f32, -1.0], [2.0 * teeth as f32, 0.0]];
        for tooth in (0..teeth).rev() {
            points.push([2.0 * tooth as f32 + 1.0, 3.0]);
            points.push([2.0 * tooth as f32, 0.0]);
        }
        let comb = flat(&points);
        let (triangles, outcome) = cut(&comb);
        assert_eq!(outcome, Cut::Exact);
        assert_eq!(area(&comb, &triangles), (f64::from(teeth) * (2.0 + 3.0), true));
    }

    #[test]
    fn a_crossing_polygon_ends_and_says_so() {
        let bow_tie = flat(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.5], [-1.0, 3.0]]);
        cut(&bow_tie);
        let eight = flat(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]]);
        assert_eq!(cut(&eight).1, Cut::Rough);
    }

    #[test]
    fn work_is_bounded() {
        let mut spiky = Vec::new();
        for i in 0..20_000_i32 {
            let angle = f64::from(i) / 20_000.0 * std::f64::consts::TAU;
            let radius = if i % 2 == 0 { 1.0 } else { 0.5 };
            spiky.push([(radius * angle.cos()) as f32, (radius * angle.sin()) as f32, 0.0]);
        }
        let mut triangulator = Triangulator { steps_left: 1000 };
        let mut triangles = 0;
        assert_eq!(triangulator.cut(&spiky, |_| triangles += 1), Cut::Rough);
        assert_eq!(triangles, spiky.len() - 2);
    }
}
