//! The `where` of a stage: which clips it works on.

use crate::annotate::Gait;
use crate::inputs::settings::fits_name;
use crate::motion::Format;
use serde::de::value::StrDeserializer;
use serde::de::{self, IntoDeserializer, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use std::fmt;
use std::marker::PhantomData;

/// Conditions that a clip has to meet, all of them. Of a list, one is enough; an empty list asks nothing.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ClipFilter {
    /// Source labels.
    #[serde(deserialize_with = "one_or_many")]
    pub source: Vec<String>,
    /// Names or last components of names; `*` stands for anything.
    #[serde(deserialize_with = "one_or_many")]
    pub name: Vec<String>,
    /// File formats.
    #[serde(deserialize_with = "one_or_many")]
    pub format: Vec<Format>,
    /// Gait classes.
    #[serde(deserialize_with = "one_or_many")]
    pub gait: Vec<Gait>,
    /// Least confidence in the gait, 0..1.
    pub min_gait_confidence: Option<f64>,
    /// Shortest duration.
    pub min_duration_s: Option<f64>,
    /// Longest duration.
    pub max_duration_s: Option<f64>,
}

/// What a filter asks about. None: not known (yet), which meets no condition on it.
#[derive(Clone, Copy, Debug, Default)]
#[allow(missing_docs, reason = "as SCHEMA, clips")]
pub struct ClipFacts<'a> {
    pub source: &'a str,
    pub name: &'a str,
    pub format: Option<Format>,
    pub gait: Option<Gait>,
    pub gait_confidence: Option<f64>,
    pub duration_s: Option<f64>,
}

impl ClipFilter {
    /// Fields that can be told from a file's name, before it is read.
    pub(crate) const KNOWN_BEFORE_READING: [&'static str; 3] = ["source", "name", "format"];

    /// Whether the clip meets all conditions.
    pub fn lets_through(&self, clip: &ClipFacts<'_>) -> bool {
        let Self { source, name, format, gait, min_gait_confidence, min_duration_s, max_duration_s } = self;
        (source.is_empty() || source.iter().any(|wanted| wanted == clip.source))
            && (name.is_empty() || name.iter().any(|pattern| fits_name(pattern, clip.name)))
            && (format.is_empty() || clip.format.is_some_and(|own| format.contains(&own)))
            && (gait.is_empty() || clip.gait.is_some_and(|own| gait.contains(&own)))
            && min_gait_confidence.is_none_or(|least| clip.gait_confidence.is_some_and(|own| own >= least))
            && min_duration_s.is_none_or(|least| clip.duration_s.is_some_and(|own| own >= least))
            && max_duration_s.is_none_or(|most| clip.duration_s.is_some_and(|own| own <= most))
    }

    /// Whether it asks nothing.
    pub fn is_empty(&self) -> bool {
        *self == ClipFilter::default()
    }
}

/// `gait = "walk"` as well as `gait = ["walk", "run"]`.
fn one_or_many<'de, D: Deserializer<'de>, T: Deserialize<'de>>(deserializer: D) -> Result<Vec<T>, D::Error> {
    struct OneOrMany<T>(PhantomData<T>);

    impl<'de, T: Deserialize<'de>> Visitor<'de> for OneOrMany<T> {
        type Value = Vec<T>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("text or a list of texts")
        }

        fn visit_str<E: de::Error>(self, word: &str) -> Result<Vec<T>, E> {
            let word: StrDeserializer<'_, E> = word.into_deserializer();
            Ok(vec![T::deserialize(word)?])
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut words: A) -> Result<Vec<T>, A::Error> {
            let mut all = Vec::new();
            while let Some(word) = words.next_element()? {
                all.push(word);
            }
            Ok(all)
        }
    }

    deserializer.deserialize_any(OneOrMany(PhantomData))
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLIP: ClipFacts<'_> = ClipFacts {
        source: "cmu",
        name: "02/02_01",
        format: Some(Format::Amc),
        gait: Some(Gait::Walk),
        gait_confidence: Some(0.9),
        duration_s: Some(2.86),
    };

    fn lets(filter: ClipFilter) -> bool {
        filter.lets_through(&CLIP)
    }

    #[test]
    fn every_condition_counts_and_of_a_list_one_is_enough() {
        let text = |word: &str| vec![word.to_owned()];
        assert!(lets(ClipFilter::default()));
        assert!(lets(ClipFilter { gait: vec![Gait::Run, Gait::Walk], ..Default::default() }));
        assert!(!lets(ClipFilter { gait: vec![Gait::Run], ..Default::default() }));
        assert!(lets(ClipFilter { name: text("02_*"), source: text("cmu"), ..Default::default() }));
        assert!(!lets(ClipFilter { name: text("02_*"), source: text("lafan"), ..Default::default() }));
        assert!(!lets(ClipFilter { format: vec![Format::Bvh], ..Default::default() }));
        assert!(lets(ClipFilter { min_duration_s: Some(2.86), max_duration_s: Some(2.86), ..Default::default() }));
        assert!(!lets(ClipFilter { min_duration_s: Some(2.87), ..Default::default() }));
        assert!(!lets(ClipFilter { max_duration_s: Some(2.85), ..Default::default() }));
        assert!(!lets(ClipFilter { min_gait_confidence: Some(0.95), ..Default::default() }));
    }

    #[test]
    fn what_is_not_known_meets_no_condition() {
        let unknown = ClipFacts { gait: None, duration_s: None, ..CLIP };
        assert!(ClipFilter::default().lets_through(&unknown));
        assert!(!ClipFilter { gait: vec![Gait::Walk], ..Default::default() }.lets_through(&unknown));
        assert!(!ClipFilter { max_duration_s: Some(9.0), ..Default::default() }.lets_through(&unknown));
    }
}
