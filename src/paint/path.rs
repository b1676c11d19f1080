//! The sorted path through the column colours of a strip: the recursion of section 4.1 and figure 4.3 of the thesis.
//!
//! A strip's column means walk from its first colour to its last, but stagger: single strokes make single columns too
//! light or too dark. The recursion keeps the colours that lead from one end to the other, in that order, and drops
//! those that deviate. It knows colours only; when each of them is reached is settled by [`super::timing`].

use std::collections::VecDeque;

use super::rgb::{distance_squared, dot, sub, Rgb};
use super::smooth::low_pass;

/// Columns of `colors` in the order of the sorted path: the first column, kept columns, the last column.
///
/// A strip that comes back to its first colour (see [`turning_column`]) is sorted up to its turn, and on from there.
/// Columns of exactly equal colour that stand side by side in the path are put in the strip's order.
///
/// `search_scale` must not be negative or NaN; `half_width` (in columns) is the reach of the low-pass that keeps
/// streaks from deciding on the turn.
pub(super) fn sorted_path(colors: &[Rgb], search_scale: f64, half_width: f64) -> Vec<usize> {
    let Some(last) = colors.len().checked_sub(1) else { return Vec::new() };
    let mut path = match turning_column(colors, half_width) {
        Some(turn) => {
            let mut path = sort_between(colors, 0, turn, search_scale);
            path.extend(sort_between(colors, turn, last, search_scale).into_iter().skip(1));
            path
        }
        None => sort_between(colors, 0, last, search_scale),
    };
    for equal in path.chunk_by_mut(|&a, &b| colors[a] == colors[b]) {
        equal.sort_unstable();
    }
    path
}

/// The recursion on the columns `first..=last`, which it is seeded with.
///
/// For two neighbours A and B of the path, the colour C of the set that is closest to their midpoint M enters between
/// them if it lies in the closed sphere about M of radius `search_scale * |AB| / 2`; ties go to the lowest column. Then
/// the same is done for A and C, and for C and B. A column enters the path once, so this ends for any factor. It is
/// done level by level, coarse before fine: with a factor above 1 a depth-first order lets the first half take the
/// colours that belong to the second (from a factor of about 1.5 the path falls apart).
fn sort_between(colors: &[Rgb], first: usize, last: usize, search_scale: f64) -> Vec<usize> {
    if first == last {
        return vec![first];
    }
    // The linked list of the thesis: the column that follows in the path.
    let mut next = vec![last; colors.len()];
    let mut free: Vec<(usize, Rgb)> = (first + 1..last).map(|column| (column, colors[column])).collect();
    let mut open = VecDeque::from([(first, last)]);
    while let Some((a, b)) = open.pop_front() {
        if let Some(index) = closest_to_midpoint(colors[a], colors[b], search_scale, &free) {
            let (c, _) = free.remove(index);
            next[a] = c;
            next[c] = b;
            open.extend([(a, c), (c, b)]);
        }
    }
    std::iter::successors(Some(first), |&column| (column != last).then(|| next[column])).collect()
}

/// Index into `free` of the colour nearest to the midpoint of `a` and `b`, if that colour lies in the search sphere.
///
/// With M the midpoint, |C - M|^2 = (C - A).(C - B) + |AB|^2 / 4. So the product (C - A).(C - B) alone orders the
/// colours by their distance from M, and tells who is inside; a copy of A or B gives 0, exactly on the border of the
/// sphere with the diameter AB.
fn closest_to_midpoint(a: Rgb, b: Rgb, search_scale: f64, free: &[(usize, Rgb)]) -> Option<usize> {
    let limit = (search_scale * search_scale - 1.0) * distance_squared(a, b) / 4.0;
    let mut best = None;
    let mut least = f64::INFINITY;
    for (index, &(_, c)) in free.iter().enumerate() {
        let product = dot(sub(c, a), sub(c, b));
        if product <= limit && product < least {
            best = Some(index);
            least = product;
        }
    }
    best
}

/// The column where a strip turns back that ends near the colour it began with; `None` for one that leads somewhere.
///
/// Two seeds of equal colour span no sphere at all, whatever its factor, and the whole strip would be dropped. So where
/// the strip has colours farther from both ends than these are from each other, the farthest becomes a third seed. From
/// two, it could be reached only in a search area scaled by more than 1.7, which lets most streaks in as well.
fn turning_column(colors: &[Rgb], half_width: f64) -> Option<usize> {
    let last = colors.len() - 1;
    let (first, end) = (colors[0], colors[last]);
    let mut farthest = (None, distance_squared(first, end));
    let smooth = low_pass(colors, half_width);
    for (column, &color) in smooth.iter().enumerate().take(last).skip(1) {
        let distance = distance_squared(color, first).min(distance_squared(color, end));
        if distance > farthest.1 {
            farthest = (Some(column), distance);
        }
    }
    farthest.0
}
