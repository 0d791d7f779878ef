//! Settings that were changed and have no effect as others stand.

use super::config::Config;
use crate::annotate::contacts::{ExtremaSettings, ThesisSettings};
use crate::annotate::{ContactSettings, Detector};

/// Thresholds of a detector of contacts, other than by default, while another detector is in force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IdleThresholds {
    /// The only one that goes by them.
    pub detector: Detector,
    /// The one that the settings name.
    pub in_force: Detector,
}

impl Config {
    /// Thresholds that somebody changed and that nothing goes by.
    pub fn idle_thresholds(&self) -> Vec<IdleThresholds> {
        let ContactSettings { detector: in_force, thesis, extrema } = &self.contacts;
        let in_force = *in_force;
        let changed = [
            (Detector::Thesis, *thesis != ThesisSettings::default()),
            (Detector::Extrema, *extrema != ExtremaSettings::default()),
        ];
        let idle = changed.into_iter().filter(|&(detector, changed)| changed && detector != in_force);
        idle.map(|(detector, _)| IdleThresholds { detector, in_force }).collect()
    }
}

impl IdleThresholds {
    /// What was found.
    pub fn what(&self) -> String {
        format!(
            "[contacts.{}] has no effect: the detector in force is `{}`",
            self.detector.name(),
            self.in_force.name()
        )
    }

    /// Why that may matter.
    pub fn why(&self) -> String {
        format!("these thresholds are those of the detector `{}` alone", self.detector.name())
    }

    /// What to do if they are meant.
    pub fn remedy(&self) -> String {
        format!("contacts.detector=\"{}\"", self.detector.name())
    }
}
