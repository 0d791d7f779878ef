//! From a recipe and its parents to a clip: chooses the placement that the rule asks for, then grafts.
//!
//! Cyclic donors are laid over by ankle passes. A stand donor's action goes where the base has room for it (T's
//! "nearest equal state" adds nothing there, GRAFTS 2): in the middle, at the start or at the end, wherever the base's arms
//! are idle first. A jump goes onto a jump so that both are highest at the same time.

use super::Refusal;
use super::action::{Action, ActionSettings, require_idle_arms};
use super::compose::Rule;
use super::correlation::{Footwork, alternates, frame_map};
use super::graft::{GraftSettings, GraftedClip, graft, graft_timed};
use super::parts::Part;
use super::placement::{Placement, Timing};
use super::subject::{Movement, Subject};
use super::tables::Recipe;
use crate::annotate::Gait;

/// Makes the clip of a graft recipe.
///
/// # Errors
/// [`Refusal`]; among others when the base has no room for the donor's whole action, or its arms are busy there.
pub fn make(
    recipe: &Recipe,
    base: &Subject,
    donor: &Subject,
    action: &ActionSettings,
    settings: &GraftSettings,
) -> Result<GraftedClip, Refusal> {
    let parts: Vec<Part> = recipe.chains.iter().filter_map(|chain| Part::from_name(chain)).collect();
    let rule = Rule::from_name(&recipe.rule);
    if rule.is_none_or(Rule::is_cyclic) {
        return match recipe.alternate.and_then(|alternate| usize::try_from(alternate).ok()) {
            Some(alternate) => graft(base, donor, &parts, &Placement::Correlated { alternate }, settings),
            None => graft_timed(base, donor, &parts, &first_playable(base, donor, settings)?, settings),
        };
    }
    let placements = match rule.map(Rule::donor) {
        Some(Gait::Jump) => vec![at_the_same_peak(&base.movement, &donor.movement)?],
        _ => rooms_for_the_action(&base.movement, &donor.movement, action, settings.seam_s)?,
    };
    let mut first_refusal = None;
    for placement in placements {
        if rule.is_some_and(Rule::needs_idle_arms)
            && let Err(refusal) =
                require_idle_arms(&base.movement, &parts, base_frames(&placement, base, donor), action)
        {
            first_refusal.get_or_insert(refusal);
            continue;
        }
        return graft(base, donor, &parts, &placement, settings);
    }
    Err(first_refusal.unwrap_or(Refusal::BadPlacement))
}

/// The timing of the cheapest alternate whose rate stays in bounds; the default's refusal if there is none.
fn first_playable(base: &Subject, donor: &Subject, settings: &GraftSettings) -> Result<Timing, Refusal> {
    let [on, from] = [base, donor].map(|subject| Footwork::of(&subject.movement, &settings.correlation));
    let mut refused = None;
    for alternate in alternates(&on, &from, &settings.correlation)? {
        match frame_map(&alternate, &on, &from, &settings.correlation) {
            Ok(map) => return Timing::of_map(&map, on.n_frames(), on.rate_hz),
            Err(refusal) => refused = refused.or(Some(refusal)),
        }
    }
    Err(refused.unwrap_or(Refusal::TooFewPairs))
}

fn rooms_for_the_action(
    base: &Movement,
    donor: &Movement,
    action: &ActionSettings,
    seam_s: f64,
) -> Result<Vec<Placement>, Refusal> {
    let found = Action::of(donor, action);
    if found.active == [false; 2] {
        return Err(Refusal::NoActiveArm);
    }
    let [first, end] = found.frames_with_seams(seam_s, donor.rate_hz, donor.n_frames());
    let needed_s = (end - 1 - first) as f64 / donor.rate_hz;
    let held_s = (base.n_frames() - 1) as f64 / base.rate_hz;
    let room_s = held_s - needed_s;
    if room_s < 0.0 {
        return Err(Refusal::BaseTooShort { needed_s, held_s });
    }
    // A whole number of base frames, and a hair of slack at the end for rounding.
    let at = |share: f64| Placement::At { time_s: (room_s * share * base.rate_hz).floor() / base.rate_hz, first, end };
    Ok(vec![at(0.5), at(0.0), at(1.0)])
}

fn at_the_same_peak(base: &Movement, donor: &Movement) -> Result<Placement, Refusal> {
    let peak_s = |movement: &Movement| {
        let height = |frame: usize| movement.poses.at(frame, movement.landmarks.hips).y;
        let peak = (0..movement.n_frames()).rev().max_by(|&a, &b| height(a).total_cmp(&height(b))).unwrap_or(0);
        peak as f64 / movement.rate_hz
    };
    let time_s = peak_s(base) - peak_s(donor);
    if time_s < 0.0 { Err(Refusal::BadPlacement) } else { Ok(Placement::whole_at(time_s, donor)) }
}

fn base_frames(placement: &Placement, base: &Subject, donor: &Subject) -> [usize; 2] {
    match *placement {
        Placement::Correlated { .. } => [0, base.clip.n_frames],
        Placement::At { time_s, first, end } => {
            let rate_hz = base.clip.rate_hz;
            let last_s = time_s + (end - first) as f64 / donor.clip.rate_hz;
            [(time_s * rate_hz) as usize, ((last_s * rate_hz).ceil() as usize).min(base.clip.n_frames)]
        }
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::super::walker::{walker, waver};
    use super::*;

    fn recipe(rule: &str, chains: &[&str]) -> Recipe {
        Recipe {
            recipe: "r".into(),
            kind: "graft".into(),
            base: "b".into(),
            donor: Some("d".into()),
            chains: chains.iter().map(|&chain| chain.to_owned()).collect(),
            alternate: Some(0),
            options: "{}".into(),
            seed: 0,
            rule: rule.into(),
            cell: None,
        }
    }

    #[test]
    fn a_wave_goes_into_the_middle_of_a_longer_walk() {
        let (base, donor) = (walker(30.0, 240, 1.0), waver(30.0, 90));
        let settings = (ActionSettings::default(), GraftSettings::default());
        let action = Action::of(&donor.movement, &settings.0);
        let chains: Vec<&str> = action.parts().iter().map(|part| part.name()).collect();
        let made = make(&recipe("walk<-stand", &chains), &base, &donor, &settings.0, &settings.1).unwrap();
        let [first, end] = made.base_range;
        assert!(first.abs_diff(240 - end) <= 2, "{first} {end}");
        let short = make(&recipe("walk<-stand", &chains), &walker(30.0, 40, 1.0), &donor, &settings.0, &settings.1);
        assert!(matches!(short, Err(Refusal::BaseTooShort { .. })));
    }

    #[test]
    fn a_busy_arm_of_a_standing_base_is_refused() {
        let (base, donor) = (waver(30.0, 200), waver(30.0, 90));
        let settings = (ActionSettings::default(), GraftSettings::default());
        let chains: Vec<&str> =
            Action::of(&donor.movement, &settings.0).parts().iter().map(|part| part.name()).collect();
        let made = make(&recipe("stand<-stand", &chains), &base, &donor, &settings.0, &settings.1);
        assert!(matches!(made, Err(Refusal::BaseArmBusy(_))), "{:?}", made.map(|made| made.base_range));
    }
}
