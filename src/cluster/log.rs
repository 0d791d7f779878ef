//! The merges of a tree as they are made, and what they need to know of each item.

use super::tables::Merge;

/// The merges so far, and how many samples each item has.
pub(super) struct Log {
    pub(super) merges: Vec<Merge>,
    pub(super) members: Vec<u32>,
    radius2: Vec<f64>,
}

impl Log {
    pub(super) fn new(n_samples: usize) -> Log {
        Log { merges: Vec::new(), members: vec![1; n_samples], radius2: vec![0.0; n_samples] }
    }

    /// Writes a merge of two items at a squared distance down; returns the new item.
    pub(super) fn merge(&mut self, e: f64, a: u32, b: u32) -> u32 {
        let [members_a, members_b] = [a, b].map(|item| self.members[item as usize]);
        let [radius2_a, radius2_b] = [a, b].map(|item| self.radius2[item as usize]);
        let members = members_a + members_b;
        let (share_a, share_b) = (f64::from(members_a) / f64::from(members), f64::from(members_b) / f64::from(members));
        // Mean squares add up about the common mean by its distance to either part's.
        let radius2 = share_a * radius2_a + share_b * radius2_b + share_a * share_b * e;
        let item = self.members.len() as u32;
        self.members.push(members);
        self.radius2.push(radius2);
        self.merges.push(Merge { item, a, b, e, members, radius2 });
        item
    }
}
