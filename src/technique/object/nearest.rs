//! The nearest of a set of points from which points are taken away: a k-d tree that counts what is left below each
//! node.

use glam::DVec3;

/// Points of a leaf.
const LEAF: usize = 8;

/// The tree. Node 0 is the root; the children of a node lie behind one another.
pub(super) struct NearestTree {
    points: Vec<DVec3>,
    /// The points' numbers, those of a node side by side.
    order: Vec<u32>,
    nodes: Vec<Node>,
    /// The leaf of each point.
    leaf: Vec<u32>,
    there: Vec<bool>,
}

struct Node {
    low: DVec3,
    high: DVec3,
    /// Its part of the order.
    begin: u32,
    end: u32,
    /// The first of its two children; 0 for a leaf.
    children: u32,
    parent: u32,
    left: u32,
}

impl NearestTree {
    /// A tree of all of these points.
    pub fn new(points: &[DVec3]) -> Self {
        let count = points.len();
        let mut tree = NearestTree {
            points: points.to_vec(),
            order: (0..count as u32).collect(),
            nodes: Vec::new(),
            leaf: vec![0; count],
            there: vec![true; count],
        };
        tree.push(0, count, 0);
        // Children are appended behind all nodes there are, so this reaches them too.
        let mut at = 0;
        while at < tree.nodes.len() {
            tree.split(at);
            at += 1;
        }
        tree
    }

    fn push(&mut self, begin: usize, end: usize, parent: usize) {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &i in &self.order[begin..end] {
            low = low.min(self.points[i as usize]);
            high = high.max(self.points[i as usize]);
        }
        let [begin, end, parent] = [begin, end, parent].map(|n| n as u32);
        self.nodes.push(Node { low, high, begin, end, children: 0, parent, left: end - begin });
    }

    fn split(&mut self, at: usize) {
        let (begin, end) = (self.nodes[at].begin as usize, self.nodes[at].end as usize);
        if end - begin <= LEAF {
            self.order[begin..end].iter().for_each(|&i| self.leaf[i as usize] = at as u32);
            return;
        }
        let size = self.nodes[at].high - self.nodes[at].low;
        let axis = (0..3).max_by(|&a, &b| size[a].total_cmp(&size[b])).unwrap_or_default();
        let middle = (end - begin) / 2;
        let points = &self.points;
        self.order[begin..end]
            .select_nth_unstable_by(middle, |&a, &b| points[a as usize][axis].total_cmp(&points[b as usize][axis]));
        self.nodes[at].children = self.nodes.len() as u32;
        self.push(begin, begin + middle, at);
        self.push(begin + middle, end, at);
    }

    /// Takes a point away, if it is there.
    pub fn remove(&mut self, point: u32) {
        if !std::mem::replace(&mut self.there[point as usize], false) {
            return;
        }
        let mut at = self.leaf[point as usize] as usize;
        loop {
            self.nodes[at].left -= 1;
            if at == 0 {
                return;
            }
            at = self.nodes[at].parent as usize;
        }
    }

    /// The nearest point that is there, of equally near ones the lowest number, and its squared distance.
    pub fn nearest(&self, to: DVec3) -> Option<(u32, f64)> {
        let mut best: Option<(u32, f64)> = None;
        let mut stack = vec![0u32];
        while let Some(at) = stack.pop() {
            let node = &self.nodes[at as usize];
            let reach = (to.clamp(node.low, node.high) - to).length_squared();
            if node.left == 0 || best.is_some_and(|(_, distance)| reach > distance) {
                continue;
            }
            if node.children == 0 {
                for &i in &self.order[node.begin as usize..node.end as usize] {
                    let distance = self.points[i as usize].distance_squared(to);
                    let closer = best.is_none_or(|(j, least)| distance < least || (distance == least && i < j));
                    if self.there[i as usize] && closer {
                        best = Some((i, distance));
                    }
                }
                continue;
            }
            // The closer child last, so that it comes first.
            let distance = |child: u32| {
                let node = &self.nodes[child as usize];
                (to.clamp(node.low, node.high) - to).length_squared()
            };
            let (a, b) = (node.children, node.children + 1);
            stack.extend(if distance(a) < distance(b) { [b, a] } else { [a, b] });
        }
        best
    }
}
