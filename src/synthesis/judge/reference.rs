//! What the judge holds clips against beside their parents: figures of the captures, frozen by the first enrichment (DESIGN 4).

use super::super::subject::Movement;
use super::joint_ranges::{JointRange, RangeCounts, limit_excess};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Raised when the numbers of a reference come to mean something else: other cells, bins, joints or bones.
const VERSION: u32 = 1;

/// The frozen reference, by layout. Empty by default: nothing is measured by it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reference {
    version: u32,
    layouts: BTreeMap<String, LayoutReference>,
}

/// The reference of one layout.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct LayoutReference {
    /// How long the clips last that it was taken from, milliseconds.
    captured_ms: u64,
    /// By unique name of the joint.
    joint_ranges: BTreeMap<String, JointRange>,
}

/// What a reference is made of: counts of captured clips, by layout.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReferenceCounts {
    layouts: BTreeMap<String, RangeCounts>,
}

impl Default for Reference {
    fn default() -> Reference {
        Reference { version: VERSION, layouts: BTreeMap::new() }
    }
}

impl ReferenceCounts {
    /// Adds the counts of a clip.
    pub fn add(&mut self, layout: &str, counts: RangeCounts) {
        self.layouts.entry(layout.to_owned()).or_default().add(counts);
    }
}

impl Reference {
    /// Enters the layouts that it lacks, or knows from less than `min_s` seconds; the others are frozen and stay.
    pub fn enter(&mut self, counts: &ReferenceCounts, min_s: f64) {
        for (layout, counts) in &counts.layouts {
            if self.layouts.get(layout).is_none_or(|known| !known.lasts(min_s)) {
                let entry = LayoutReference { captured_ms: counts.captured_ms(), joint_ranges: counts.ranges() };
                self.layouts.insert(layout.clone(), entry);
            }
        }
    }

    /// The reference without the layouts that it knows from less than `min_s` seconds.
    pub fn lasting(mut self, min_s: f64) -> Reference {
        self.layouts.retain(|_, known| known.lasts(min_s));
        self
    }

    /// Number of layouts in it.
    pub fn n_layouts(&self) -> usize {
        self.layouts.len()
    }

    /// Whether it is of this version and its numbers can be used.
    pub fn is_sound(&self) -> bool {
        let ranges = self.layouts.values().flat_map(|known| known.joint_ranges.values());
        self.version == VERSION && ranges.into_iter().all(JointRange::is_sound)
    }

    /// How far a clip turns its joints beyond the captures of its layout: [`limit_excess`]. None: the layout is not in it.
    pub fn limit_excess(&self, movement: &Movement) -> Option<f64> {
        limit_excess(movement, &self.layouts.get(&movement.skeleton.layout_id())?.joint_ranges)
    }
}

impl LayoutReference {
    fn lasts(&self, min_s: f64) -> bool {
        self.captured_ms as f64 >= 1000.0 * min_s
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::super::super::walker::{mover, walker};
    use super::*;
    use crate::motion::Role;

    #[test]
    fn what_is_frozen_stays_and_what_lacks_is_entered() {
        let [short, walk] = [9.0, 10.0].map(|seconds| walker(30.0, (30.0 * seconds) as usize, 1.0).movement);
        let bent = mover(30.0, 300, 1.0, 0.0, &|_, _| vec![(Role::ElbowLeft, [-90.0, 0.0, 0.0])]).movement;
        let layout = walk.skeleton.layout_id();
        let counts = |layouts: &[(&str, &Movement)]| {
            let mut counts = ReferenceCounts::default();
            layouts.iter().for_each(|(layout, movement)| counts.add(layout, RangeCounts::of(movement)));
            counts
        };
        let mut reference = Reference::default();
        assert_eq!(reference.limit_excess(&walk), None);
        reference.enter(&counts(&[(&layout, &short)]), 10.0);
        assert_eq!(reference.clone().lasting(9.0).n_layouts(), 1);
        assert_eq!(reference.clone().lasting(10.0).limit_excess(&walk), None, "known from too little");
        reference.enter(&counts(&[(&layout, &walk)]), 10.0);
        let lasting = reference.clone().lasting(10.0);
        assert_eq!(lasting.limit_excess(&walk), Some(0.0));
        let excess = lasting.limit_excess(&bent);
        assert!(excess.unwrap() > 1.0, "{excess:?}");
        reference.enter(&counts(&[(&layout, &bent), ("Lother", &walk)]), 10.0);
        assert_eq!((reference.n_layouts(), reference.limit_excess(&bent)), (2, excess));
        assert!(reference.is_sound());
        assert!(!Reference { version: VERSION + 1, ..reference }.is_sound());
    }
}
