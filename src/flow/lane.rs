//! The time of the clips dataflow: the n-th shard of a worker, incomparable between workers.
//!
//! With a total order of shards a slow one would hold back the commits of all that come after it, on every
//! worker; and since a worker may have only two shards open, their work as well (DATAFLOW 1).

use serde::{Deserialize, Serialize};
use timely::order::PartialOrder;
use timely::progress::Timestamp;
use timely::progress::timestamp::{PathSummary, Refines};

/// A logical time: before everything, or the n-th shard that a worker took.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub(crate) enum Lane {
    /// The least time.
    Start,
    /// The n-th shard of a worker.
    At(u32, u64),
}

impl PartialOrder for Lane {
    fn less_equal(&self, other: &Self) -> bool {
        match (self, other) {
            (Lane::Start, _) => true,
            (Lane::At(a, n), Lane::At(b, m)) => a == b && n <= m,
            (Lane::At(..), Lane::Start) => false,
        }
    }
}

impl Timestamp for Lane {
    type Summary = ();

    fn minimum() -> Self {
        Lane::Start
    }
}

impl PathSummary<Lane> for () {
    fn results_in(&self, time: &Lane) -> Option<Lane> {
        Some(*time)
    }

    fn followed_by(&self, _other: &Self) -> Option<Self> {
        Some(())
    }
}

impl Refines<()> for Lane {
    fn to_inner(_outer: ()) -> Self {
        Lane::Start
    }

    fn to_outer(self) {}

    fn summarize(_path: ()) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_of_two_workers_are_incomparable() {
        assert!(Lane::Start.less_equal(&Lane::At(1, 0)));
        assert!(!Lane::At(0, 0).less_equal(&Lane::Start));
        assert!(Lane::At(0, 1).less_equal(&Lane::At(0, 2)));
        assert!(!Lane::At(0, 2).less_equal(&Lane::At(0, 1)));
        assert!(!Lane::At(0, 1).less_equal(&Lane::At(1, 1)));
        assert!(!Lane::At(1, 1).less_equal(&Lane::At(0, 5)));
    }
}
