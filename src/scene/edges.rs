//! The edges of a mesh, for what asks which faces meet there ([`super::normals`], [`super::solid`]).

/// An edge as a triangle has it: its two places, the lower one first, and the corner that it starts at.
pub(super) type Edge = (u32, u32, u32);

/// The corner that follows in the same triangle; corner `3 t + k` is corner `k` of triangle `t`.
pub(super) fn following(corner: u32) -> u32 {
    corner - corner % 3 + (corner + 1) % 3
}

/// All edges of the triangles whose corners are at these places, in order, so that equal edges are side by side.
///
/// Few edges have the same lower place. Counting the edges of each place, and sorting only those among themselves,
/// takes a third of the time that sorting them all does.
pub(super) fn sorted_edges(places: &[u32]) -> Vec<Edge> {
    let edge = |corner: u32| {
        let (a, b) = (places[corner as usize], places[following(corner) as usize]);
        (a.min(b), a.max(b), corner)
    };
    let corners = || 0..places.len() as u32;
    // Where the edges of each place end; while they are put in, from the last to the first, where those begin that are.
    let mut ends = vec![0_usize; places.iter().max().map_or(0, |last| *last as usize + 1)];
    corners().for_each(|corner| ends[edge(corner).0 as usize] += 1);
    let mut sum = 0;
    for end in &mut ends {
        sum += *end;
        *end = sum;
    }
    let mut edges = vec![Edge::default(); places.len()];
    for edge in corners().map(edge) {
        let begin = &mut ends[edge.0 as usize];
        *begin -= 1;
        edges[*begin] = edge;
    }
    edges.chunk_by_mut(|a, b| a.0 == b.0).for_each(<[Edge]>::sort_unstable);
    edges
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_edges_are_there_in_order() {
        // Two triangles that share an edge, one that doubles it, and one with two corners at one place.
        let places = [7, 2, 4, 2, 7, 9, 4, 7, 2, 0, 0, 2];
        let mut expected: Vec<Edge> = (0..12)
            .map(|corner| (corner, places[corner as usize], places[following(corner) as usize]))
            .map(|(corner, a, b)| (a.min(b), a.max(b), corner))
            .collect();
        expected.sort_unstable();
        assert_eq!(sorted_edges(&places), expected);
        assert_eq!(sorted_edges(&[]), []);
    }
}
