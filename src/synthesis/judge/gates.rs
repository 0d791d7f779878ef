//! The gates: a made clip passes if no figure is much worse than the worse of its parents' (GRAFTS 5).

use super::super::tables::Figure;
use super::arm_leg::ArmLeg;
use super::figures::{Figures, Measure};
use serde::{Deserialize, Serialize};

/// Limits of the gates: the 99th percentile of captured clips beside pretend parents. Measured once, never from the
/// user's corpus.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GateSettings {
    /// Jerk of the wrists, at most this many times the parents'.
    pub max_wrist_jerk_factor: f64,
    /// Angular acceleration above the hips, at most this many times the parents'.
    pub max_upper_angular_acceleration_factor: f64,
    /// Angular acceleration of the legs, at most this many times the parents'.
    pub max_leg_angular_acceleration_factor: f64,
    /// Skate above the parents'.
    pub max_skate_excess_mps: f64,
    /// Drift of plants above the parents'.
    pub max_plant_drift_excess_m: f64,
    /// Penetration above the parents'; a guess, untested.
    pub max_penetration_excess_m: f64,
    /// Joint ranges, above the parents'.
    pub max_limit_excess_rad: f64,
    /// Joint ranges of a layout are taken from this much of captures at least; less tells what is rare from what is wrong
    /// too badly: of captures that a reference lacks it refuses 2 in 3 if it lasts 1 minute, 1 in 10 if it lasts 9.
    pub min_reference_s: f64,
    /// Self-collision above the parents'.
    pub max_self_collision_excess_m: f64,
    /// Distance of the zero moment point above the parents'.
    pub max_zmp_distance_excess_m: f64,
    /// Distance of an arm to its nearest captured pose.
    pub max_arm_novelty: f64,
    /// The phase of arms after legs that captured gaits have.
    pub arm_leg_relation_cycles: f64,
    /// How far from it is allowed.
    pub max_arm_leg_relation_error_cycles: f64,
    /// How firmly arms and legs must be locked, 0..1.
    pub min_arm_leg_lock: f64,
}

/// What the judge says of a made clip.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Verdict {
    /// Whether no gate refused it.
    pub accepted: bool,
    /// Names of the gates that did, in the order of the measures.
    pub reasons: Vec<String>,
    /// Each gate's answer, in the order of [`Measure::ALL`]; None where there is no such gate or nothing to judge by.
    pub gates: [Option<bool>; Measure::ALL.len()],
}

impl Default for GateSettings {
    fn default() -> Self {
        GateSettings {
            max_wrist_jerk_factor: 1.6,
            max_upper_angular_acceleration_factor: 2.0,
            max_leg_angular_acceleration_factor: 2.3,
            max_skate_excess_mps: 0.012,
            max_plant_drift_excess_m: 0.008,
            max_penetration_excess_m: 0.02,
            max_limit_excess_rad: 0.037,
            min_reference_s: 600.0,
            max_self_collision_excess_m: 0.034,
            max_zmp_distance_excess_m: 0.063,
            max_arm_novelty: 0.31,
            arm_leg_relation_cycles: 0.064,
            max_arm_leg_relation_error_cycles: 0.09,
            min_arm_leg_lock: 0.95,
        }
    }
}

impl GateSettings {
    /// Whether arms swing when those of captured gaits do.
    fn is_on_time(&self, relation: f64) -> bool {
        let away = (relation - self.arm_leg_relation_cycles + 0.5).rem_euclid(1.0) - 0.5;
        away.abs() <= self.max_arm_leg_relation_error_cycles
    }

    fn is_locked(&self, lock: f64) -> bool {
        lock >= self.min_arm_leg_lock
    }

    /// Whether a clip's arms keep time with its legs as those of captured gaits do.
    pub fn is_in_step(&self, clip: &ArmLeg) -> bool {
        self.is_on_time(clip.relation) && self.is_locked(clip.lock)
    }
}

/// Holds a made clip against its parents, all measured at one rate.
///
/// `cyclic`: the donor steps and so does the base, so that arms have to keep time with the legs; elsewhere their
/// relation is measured but not judged.
pub fn judge(own: &Figures, base: &Figures, donor: &Figures, cyclic: bool, settings: &GateSettings) -> Verdict {
    let gates = Measure::ALL.map(|measure| {
        let value = own.get(measure)?;
        let parents = || match (base.get(measure), donor.get(measure)) {
            (Some(a), Some(b)) => Some(a.max(b)),
            (a, b) => a.or(b),
        };
        let times = |factor: f64| Some(value <= factor * parents()?);
        let plus = |excess: f64| Some(value <= parents()? + excess);
        match measure {
            Measure::WristJerk => times(settings.max_wrist_jerk_factor),
            Measure::UpperAngularAcceleration => times(settings.max_upper_angular_acceleration_factor),
            Measure::LegAngularAcceleration => times(settings.max_leg_angular_acceleration_factor),
            Measure::Skate => plus(settings.max_skate_excess_mps),
            Measure::PlantDrift => plus(settings.max_plant_drift_excess_m),
            Measure::Penetration => plus(settings.max_penetration_excess_m),
            Measure::LimitExcess => plus(settings.max_limit_excess_rad),
            Measure::SelfCollision => plus(settings.max_self_collision_excess_m),
            Measure::ZmpDistance => plus(settings.max_zmp_distance_excess_m),
            Measure::ArmNovelty => Some(value <= settings.max_arm_novelty),
            Measure::ArmLegRelation if cyclic => Some(settings.is_on_time(value)),
            Measure::ArmLegLock if cyclic => Some(settings.is_locked(value)),
            // A score: distance in a joint space of arms and legs condemns the pairs that nobody performed.
            Measure::ArmLegRelation | Measure::ArmLegLock | Measure::PoseNovelty => None,
        }
    });
    let refused = |measure: &Measure| gates[*measure as usize] == Some(false);
    let reasons: Vec<String> = Measure::ALL.into_iter().filter(refused).map(|m| m.name().to_owned()).collect();
    Verdict { accepted: reasons.is_empty(), reasons, gates }
}

/// The figures as rows of `made`.
pub fn figure_rows(own: &Figures, base: &Figures, donor: Option<&Figures>) -> Vec<Figure> {
    let table = |figures: &Figures, measure| figures.get(measure).map(|value| value as f32);
    let row = |measure: Measure| Figure {
        name: measure.name().to_owned(),
        own: table(own, measure),
        base: table(base, measure),
        donor: donor.and_then(|donor| table(donor, measure)),
    };
    Measure::ALL.into_iter().map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Figures that are all 1, but for those given.
    fn figures(given: &[(Measure, Option<f64>)]) -> Figures {
        let ones = Measure::ALL.into_iter().fold(Figures::default(), |figures, m| figures.with(m, Some(1.0)));
        given.iter().fold(ones, |figures, &(measure, value)| figures.with(measure, value))
    }

    fn verdict(given: &[(Measure, Option<f64>)], cyclic: bool) -> Verdict {
        // What the parents do not bound is good unless given.
        let own = figures(&[(Measure::ArmNovelty, Some(0.1)), (Measure::ArmLegRelation, Some(0.05))]);
        let own = given.iter().fold(own, |figures, &(measure, value)| figures.with(measure, value));
        judge(&own, &figures(&[]), &figures(&[]), cyclic, &GateSettings::default())
    }

    #[test]
    fn each_gate_refuses_its_own_fault_and_nothing_else() {
        assert!(verdict(&[], true).accepted);
        let limits = [
            (Measure::WristJerk, 1.59, 1.61),
            (Measure::UpperAngularAcceleration, 1.99, 2.01),
            (Measure::LegAngularAcceleration, 2.29, 2.31),
            (Measure::Skate, 1.011, 1.013),
            (Measure::PlantDrift, 1.007, 1.009),
            (Measure::Penetration, 1.019, 1.021),
            (Measure::LimitExcess, 1.036, 1.038),
            (Measure::SelfCollision, 1.033, 1.035),
            (Measure::ZmpDistance, 1.062, 1.064),
            (Measure::ArmNovelty, 0.30, 0.32),
            (Measure::ArmLegRelation, 0.153, 0.155),
            (Measure::ArmLegRelation, -0.025, -0.027),
            (Measure::ArmLegLock, 0.951, 0.949),
        ];
        for (measure, good, bad) in limits {
            assert!(verdict(&[(measure, Some(good))], true).accepted, "{measure:?}");
            let refused = verdict(&[(measure, Some(bad))], true);
            assert_eq!((refused.accepted, refused.reasons), (false, vec![measure.name().to_owned()]));
            assert!(!verdict(&[(measure, Some(f64::NAN))], true).accepted, "{measure:?}");
        }
        assert!(verdict(&[(Measure::PoseNovelty, Some(99.0))], true).accepted);
    }

    #[test]
    fn the_worse_parent_counts_and_what_is_missing_is_not_judged() {
        let mild = figures(&[]);
        let wild = figures(&[(Measure::WristJerk, Some(10.0))]);
        let own = figures(&[(Measure::WristJerk, Some(15.0)), (Measure::ArmNovelty, None)]);
        let settings = GateSettings::default();
        let jerk = Measure::WristJerk as usize;
        assert_eq!(judge(&own, &mild, &wild, false, &settings).gates[jerk], Some(true));
        assert_eq!(judge(&own, &mild, &mild, false, &settings).gates[jerk], Some(false));
        assert_eq!(judge(&own, &mild, &Figures::default(), false, &settings).gates[jerk], Some(false));
        assert_eq!(judge(&own, &Figures::default(), &Figures::default(), false, &settings).gates[jerk], None);
        let late = [(Measure::ArmLegRelation, Some(0.4)), (Measure::ArmLegLock, Some(0.2))];
        assert!(verdict(&late, false).accepted && !verdict(&late, true).accepted);
    }

    #[test]
    fn every_measure_has_a_row() {
        let rows = figure_rows(&figures(&[]), &Figures::default(), None);
        assert_eq!(rows.len(), 13);
        assert_eq!(
            (rows[0].name.as_str(), rows[0].own, rows[0].base, rows[0].donor),
            ("wrist_jerk", Some(1.0), None, None)
        );
    }
}
