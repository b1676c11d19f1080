//! By which of its paths a search goes. All of them give the same bytes; which is the fastest depends on the device.

use crate::gpu::{Context, DeviceKind};
use crate::{Error, Result};

/// From so many pixel comparisons on, pruning pays for its preparation on a CPU device.
const PRUNED_COMPARISONS: u64 = 100_000_000;

/// A block with fewer costs about as much pruned as not: there is as much to do for it whatever its positions are.
const PRUNED_BLOCK: u64 = 3_000_000;

/// How to search. The texture is the same.
///
/// A plain value, to be kept wherever a program keeps its settings; [`super::calibrate::calibrate`] finds it by trying.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SearchPath {
    /// Invocations of a full search that share a tile of positions: 1, 2, 4 or 8.
    pub parts: u32,
    /// From so many pixel comparisons of a whole quilting on ([`super::quilt::Quilt::comparisons`] of a full search),
    /// positions that cannot be chosen are left out before they are compared, where a block has many: 0 wherever it is
    /// possible, [`SearchPath::NEVER`] not at all.
    pub prune_from: u64,
}

impl SearchPath {
    /// What a tile can be shared by.
    pub const PARTS: [u32; 4] = [1, 2, 4, 8];
    /// The [`SearchPath::prune_from`] of searches that compare every allowed position.
    pub const NEVER: u64 = u64::MAX;

    /// What is expected to be fast on a device of this kind.
    pub fn for_device(context: &Context) -> Self {
        if context.caps().kind == DeviceKind::Cpu {
            // A CPU has no idle lanes to share a tile with.
            SearchPath { parts: 1, prune_from: PRUNED_COMPARISONS }
        } else {
            SearchPath { parts: 4, prune_from: Self::NEVER }
        }
    }

    /// The same, with a search that is pruned or not.
    pub(super) fn with_pruning(self, pruning: Pruning) -> Self {
        match pruning {
            Pruning::Auto => self,
            Pruning::On => SearchPath { prune_from: 0, ..self },
            Pruning::Off => SearchPath { prune_from: Self::NEVER, ..self },
        }
    }

    /// Whether some searches are pruned.
    pub(super) fn may_prune(self) -> bool {
        self.prune_from != Self::NEVER
    }

    /// Whether to prune a search for so many blocks of so many pixel comparisons each.
    pub(super) fn prunes(self, blocks: u64, comparisons: u64) -> bool {
        let enough = blocks.saturating_mul(comparisons) >= self.prune_from && comparisons >= PRUNED_BLOCK;
        self.may_prune() && (self.prune_from == 0 || enough)
    }

    pub(super) fn check(self) -> Result<()> {
        if Self::PARTS.contains(&self.parts) {
            return Ok(());
        }
        Err(Error::parameter("parts of a search", self.parts, "1, 2, 4 or 8"))
    }
}

/// Whether a search leaves out positions that cannot be chosen. The texture is the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Pruning {
    /// Where it is expected to pay.
    #[default]
    Auto,
    /// Wherever it is possible.
    On,
    /// Every allowed position is compared.
    Off,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn searches_are_pruned_from_the_least_comparisons_on() {
        let from = |prune_from| SearchPath { parts: 1, prune_from };
        let many = PRUNED_BLOCK;
        assert!(from(0).prunes(0, 0) && from(0).prunes(1, 1));
        assert!(from(3 * many).prunes(3, many) && from(3 * many).prunes(u64::MAX, many + 1));
        assert!(!from(3 * many).prunes(2, many) && !from(3 * many).prunes(100, many - 1));
        assert!(!from(SearchPath::NEVER).prunes(u64::MAX, u64::MAX) && !from(SearchPath::NEVER).may_prune());
    }

    #[test]
    fn parts_that_the_search_is_not_compiled_for_are_refused() {
        for parts in 0..20 {
            let checked = SearchPath { parts, prune_from: 0 }.check();
            assert_eq!(checked.is_ok(), [1, 2, 4, 8].contains(&parts), "{parts}");
        }
    }
}
