//! What looks wrong about a clip's labels: short stable words for the `checks` column.

use super::labels::Gait;

/// A walk with more flight than this share of the clip is suspicious: a walk has none.
const FLIGHT_OF_A_WALK: f64 = 0.05;
/// A foot is planted for more than this share of a walk's stride, and for less of a run's.
const DUTY_OF_A_WALK: f64 = 0.5;
/// A clip whose hips get further than this many leg lengths from where they began has steps.
const TRAVEL_IN_LEGS: f64 = 1.0;

/// Of clips with this confidence or more hardly any is wrong (CONTACTS 1); below it a gait is doubtful.
pub const SURE: f64 = 0.8;

/// Whether a gait of this confidence, as tables have it, is doubtful.
pub fn is_doubtful(confidence: f32) -> bool {
    f64::from(confidence) < SURE
}

/// The check of a clip whose class is less sure.
pub const LOW_CONFIDENCE: &str = "low-confidence";

/// What the checks look at.
#[derive(Clone, Debug, PartialEq)]
pub struct Facts {
    /// Class of the clip.
    pub class: Gait,
    /// Confidence in the class, 0..1, as the tables have it.
    pub confidence: f32,
    /// Share of a stride that a foot is planted.
    pub duty_factor: Option<f64>,
    /// Share of the frames with neither foot planted.
    pub flight_fraction: f64,
    /// Steps between opposite feet.
    pub n_steps: usize,
    /// Whether any frame is of a jump.
    pub jumps: bool,
    /// Largest horizontal distance of the hips from where they began, in leg lengths.
    pub travel_in_legs: f64,
    /// Whether a foot's resting height was replaced by the other's.
    pub feet_rest_apart: bool,
    /// Whether each plant has a level of its own.
    pub uneven: bool,
    /// Whether a belt's speed was taken off.
    pub treadmill: bool,
}

/// The checks that a clip doesn't pass, in a fixed order:
///
/// - `walk-with-flight`: a walk with no foot planted in more than 5 % of the frames;
/// - `run-duty-over-half`: a run whose feet are planted for more than half of a stride;
/// - `walk-duty-under-half`: a walk whose feet are planted for less;
/// - `no-step`: the hips travel more than a leg length and there is neither a step nor a jump;
/// - `feet-rest-apart`: one foot rests more than 3 cm higher than the other (it never rested, or the floor isn't flat);
/// - `uneven-ground`: the body is carried where no foot is near its rest, so that every plant has a level of its own;
///   what hands carry is not known;
/// - `treadmill`: the feet stand on a belt (or the way was taken out of the clip), whose speed was taken off to find plants;
/// - `low-confidence`: the confidence in the clip's gait is below 0.8.
pub fn checks(facts: &Facts) -> Vec<String> {
    let duty = |wrong: fn(f64) -> bool| facts.duty_factor.is_some_and(wrong);
    let findings = [
        ("walk-with-flight", facts.class == Gait::Walk && facts.flight_fraction > FLIGHT_OF_A_WALK),
        ("run-duty-over-half", facts.class == Gait::Run && duty(|duty| duty > DUTY_OF_A_WALK)),
        ("walk-duty-under-half", facts.class == Gait::Walk && duty(|duty| duty < DUTY_OF_A_WALK)),
        ("no-step", facts.n_steps == 0 && !facts.jumps && facts.travel_in_legs > TRAVEL_IN_LEGS),
        ("feet-rest-apart", facts.feet_rest_apart),
        ("uneven-ground", facts.uneven),
        ("treadmill", facts.treadmill),
        (LOW_CONFIDENCE, is_doubtful(facts.confidence)),
    ];
    findings.into_iter().filter(|(_, found)| *found).map(|(name, _)| name.to_owned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_check_speaks_of_its_own_fault() {
        let good = Facts {
            class: Gait::Walk,
            confidence: 0.95,
            duty_factor: Some(0.6),
            flight_fraction: 0.01,
            n_steps: 4,
            jumps: false,
            travel_in_legs: 3.0,
            feet_rest_apart: false,
            uneven: false,
            treadmill: false,
        };
        assert!(checks(&good).is_empty());
        for (facts, wanted) in [
            (Facts { flight_fraction: 0.06, ..good.clone() }, "walk-with-flight"),
            (Facts { class: Gait::Run, ..good.clone() }, "run-duty-over-half"),
            (Facts { duty_factor: Some(0.4), ..good.clone() }, "walk-duty-under-half"),
            (Facts { n_steps: 0, class: Gait::Unknown, duty_factor: None, ..good.clone() }, "no-step"),
            (Facts { feet_rest_apart: true, ..good.clone() }, "feet-rest-apart"),
            (Facts { uneven: true, ..good.clone() }, "uneven-ground"),
            (Facts { treadmill: true, ..good.clone() }, "treadmill"),
            (Facts { confidence: 0.79, ..good.clone() }, "low-confidence"),
        ] {
            assert_eq!(checks(&facts), [wanted]);
        }
        assert!(checks(&Facts { class: Gait::Run, duty_factor: Some(0.3), flight_fraction: 0.4, ..good }).is_empty());
    }
}
