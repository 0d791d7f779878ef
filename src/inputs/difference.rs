//! What is new, changed or gone since the corpus was last fed (DESIGN 4).

use super::find::{Found, Unsure};
use std::collections::BTreeMap;

/// A clip as a manifest knows it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Keyed {
    /// Source label.
    pub source: String,
    /// Clip name.
    pub name: String,
    /// [`InputHash::key`](super::InputHash::key).
    pub key: String,
}

/// Two lists compared. Indices into `found` for the first three, into `known` for the others; each ascending.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Difference {
    /// Not known yet.
    pub new: Vec<usize>,
    /// Known with another key.
    pub changed: Vec<usize>,
    /// Known with the same key.
    pub unchanged: Vec<usize>,
    /// Known, of a source that was looked through, and not there any more.
    pub gone: Vec<usize>,
    /// Known and not found, but where it would be could not be looked at, or it is there and can't be used: not to be pruned.
    pub unsure: Vec<usize>,
}

/// Compares what was found with what is known. Sources that were not looked through say nothing about their clips.
pub fn difference(found: &[Keyed], known: &[Keyed], sources: &[String], unsure: &[Unsure]) -> Difference {
    let by_name = |keyed: &Keyed| (keyed.source.clone(), keyed.name.clone());
    let known_keys: BTreeMap<_, &str> = known.iter().map(|keyed| (by_name(keyed), keyed.key.as_str())).collect();
    let found_names: BTreeMap<_, ()> = found.iter().map(|keyed| (by_name(keyed), ())).collect();
    let mut result = Difference::default();
    for (index, keyed) in found.iter().enumerate() {
        match known_keys.get(&by_name(keyed)) {
            None => result.new.push(index),
            Some(&key) if key == keyed.key => result.unchanged.push(index),
            Some(_) => result.changed.push(index),
        }
    }
    for (index, keyed) in known.iter().enumerate() {
        if !sources.contains(&keyed.source) || found_names.contains_key(&by_name(keyed)) {
            continue;
        }
        match unsure.iter().any(|unsure| unsure.covers(&keyed.source, &keyed.name)) {
            true => result.unsure.push(index),
            false => result.gone.push(index),
        }
    }
    result
}

impl Found {
    /// Compares with what is known; `keys` are those of [`Found::inputs`], in their order.
    pub fn difference(&self, keys: &[Keyed], known: &[Keyed]) -> Difference {
        let sources: Vec<String> = self.sources.iter().map(|source| source.label.clone()).collect();
        difference(keys, known, &sources, &self.unsure)
    }
}
