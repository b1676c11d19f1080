//! The nearest source blocks of tested blocks in a k-d tree, as the thesis stores them (section 9.1), on the host.
//!
//! A k-d tree needs a distance that adds up over its axes, and the metric does not: it adds the roots of 15 histograms.
//! So the tree looks for the nearest by the Euclidean distance over all 150 counts, of which it finds the nearest
//! exactly, and the metric says how far those are. Their mean distance is therefore never below that of
//! [`super::BlockSearch`], which compares by the metric itself; that one is the measure, this one shows what the thesis
//! probably measured.
//!
//! The tree is the crate `kiddo`'s, which sets two conditions:
//! - Many items in one place would make leaves of any size (flat paint is a single place). So each different block is stored
//!   once, with the list of its pixels. `ImmutableKdTree` is the one of its trees whose leaves may hold any number, so that
//!   different blocks which share a count, as most do, break nothing either.
//! - It splits along one axis after the other, and 60,000 blocks make 11 splits: were the counts taken as they come, all of
//!   them would fall into the first two histograms. So the axes stand in the order of their variance.
//!
//! Even so, 150 axes are far too many for a tree to leave out much: for a block unlike the source's it looks at nearly
//! all (benches/README.md has figures).
//!
//! Counts and sums of their squares are integers that a float of 32 bits holds, so distances are exact and ties are
//! ties.

use super::features::{Features, BINS, HISTOGRAMS};
use super::search::{Neighbour, Source, NEAREST};
use crate::{Error, Result};
use kiddo::immutable::float::kdtree::ImmutableKdTree;
use kiddo::SquaredEuclidean;
use std::collections::hash_map::Entry;
use std::collections::HashMap;
use std::num::NonZero;

/// Axes of the tree: every bin of every histogram.
const AXES: usize = HISTOGRAMS * BINS;
/// Blocks of a leaf.
const LEAF: usize = 32;
/// Blocks that are asked for beyond those that are wanted, since the last ones are often equally near.
const SPARE: usize = 4;
/// The most different blocks of a source: each takes 600 bytes, and another 600 while the tree is built.
const MAX_KINDS: usize = 1 << 20;

/// A source's blocks in a k-d tree.
pub struct KdTree {
    tree: ImmutableKdTree<f32, u32, AXES, LEAF>,
    axes: [Axis; AXES],
    /// The different blocks.
    kinds: Vec<Features>,
    /// The pixels of each, in reading order.
    pixels: Vec<Vec<(u32, u32)>>,
    count: usize,
    block_px: u32,
}

/// One count as an axis.
#[derive(Debug, Clone, Copy)]
struct Axis {
    histogram: usize,
    bin: usize,
    /// 1, or -1 to look at it from its other end.
    sign: f32,
}

impl KdTree {
    /// Puts all blocks of a source into a tree, which takes about as long as looking for a hundred blocks in it.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a source with more than 1,048,576 different blocks.
    pub fn new(source: &Source) -> Result<Self> {
        let mut known: HashMap<Features, usize> = HashMap::new();
        let (mut kinds, mut pixels): (Vec<Features>, Vec<Vec<(u32, u32)>>) = (Vec::new(), Vec::new());
        for &pixel in source.pixels() {
            match known.entry(source.features(pixel)) {
                Entry::Occupied(kind) => pixels[*kind.get()].push(pixel),
                Entry::Vacant(_) if kinds.len() == MAX_KINDS => {
                    let allowed = format!("at most {MAX_KINDS} for a k-d tree");
                    return Err(Error::parameter("different blocks of the source", "more", allowed));
                }
                Entry::Vacant(new) => {
                    kinds.push(*new.key());
                    pixels.push(vec![pixel]);
                    new.insert(kinds.len() - 1);
                }
            }
        }
        drop(known);
        let axes = axes(&kinds);
        let points: Vec<[f32; AXES]> = kinds.iter().map(|features| point(&axes, features)).collect();
        let tree = ImmutableKdTree::new_from_slice(&points);
        Ok(KdTree { tree, axes, kinds, pixels, count: source.pixels().len(), block_px: source.block_px() })
    }

    /// The `k` nearest source pixels of each tested block by the Euclidean distance over the 150 counts; of equally
    /// near ones the first in reading order. Those `k` are ordered by the metric's own distance, of equal ones the
    /// first in reading order.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a `k` out of [`NEAREST`], or above the number of the source's blocks.
    pub fn nearest(&self, tested: &[Features], k: u32) -> Result<Vec<Vec<Neighbour>>> {
        let most = self.count.min(*NEAREST.end() as usize);
        if k < *NEAREST.start() || k as usize > most {
            return Err(Error::parameter("k", k, format!("{} to {most}", NEAREST.start())));
        }
        Ok(tested.iter().map(|features| self.nearest_of(features, k as usize)).collect())
    }

    /// How many different blocks the tree holds.
    pub fn kinds(&self) -> usize {
        self.kinds.len()
    }

    fn nearest_of(&self, tested: &Features, k: usize) -> Vec<Neighbour> {
        let query = point(&self.axes, tested);
        let asked = NonZero::<usize>::MIN.saturating_add(k + SPARE - 1);
        let mut found = self.tree.nearest_n::<SquaredEuclidean>(&query, asked);
        // The squared distance at which there are k pixels.
        let mut pixels = 0;
        let reached = found.iter().find_map(|near| {
            pixels += self.pixels[near.item as usize].len();
            (pixels >= k).then_some(near.distance)
        });
        let radius = reached.unwrap_or(f32::INFINITY);
        // Where the last one found is just as far, others may be that were not found.
        if found.last().is_some_and(|last| last.distance <= radius) && found.len() < self.kinds.len() {
            found = self.tree.within_unsorted::<SquaredEuclidean>(&query, radius);
        }
        let mut nearest: Vec<(f32, u32, (u32, u32))> = Vec::new();
        for near in found.iter().filter(|near| near.distance <= radius) {
            // Of one kind's pixels, which are in reading order, no more than k can be taken.
            let first = self.pixels[near.item as usize].iter().take(k);
            nearest.extend(first.map(|&pixel| (near.distance, near.item, pixel)));
        }
        let reading = |pixel: (u32, u32)| (pixel.1, pixel.0);
        nearest.sort_by(|a, b| a.0.total_cmp(&b.0).then(reading(a.2).cmp(&reading(b.2))));
        nearest.truncate(k);
        let by_metric = |&(_, kind, pixel): &(f32, u32, (u32, u32))| {
            let distance = tested.distance(&self.kinds[kind as usize], self.block_px);
            Neighbour { pixel, distance }
        };
        let mut nearest: Vec<Neighbour> = nearest.iter().map(by_metric).collect();
        nearest.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(reading(a.pixel).cmp(&reading(b.pixel))));
        nearest
    }
}

fn point(axes: &[Axis; AXES], features: &Features) -> [f32; AXES] {
    axes.map(|axis| axis.sign * f32::from(features.0[axis.histogram][axis.bin]))
}

/// The axes by falling variance of the counts.
fn axes(kinds: &[Features]) -> [Axis; AXES] {
    let measured = |i: usize| {
        let (histogram, bin) = (i / BINS, i % BINS);
        let counts = || kinds.iter().map(move |features| u64::from(features.0[histogram][bin]));
        let n = kinds.len() as u64;
        let (sum, squares) = (counts().sum::<u64>(), counts().map(|count| count * count).sum::<u64>());
        // kiddo splits at the median, and puts what equals it on the upper side. Where more than half of the blocks
        // have none of a count, that would leave the lower side empty; from the other end it keeps those that have
        // some.
        let zeros = counts().filter(|count| *count == 0).count() as u64;
        let sign = if zeros * 2 > n { -1.0 } else { 1.0 };
        (n * squares - sum * sum, Axis { histogram, bin, sign })
    };
    let mut axes: [(u64, Axis); AXES] = std::array::from_fn(measured);
    // Stable: of equal ones the first stays first.
    axes.sort_by_key(|(variance, _)| std::cmp::Reverse(*variance));
    axes.map(|(_, axis)| axis)
}
