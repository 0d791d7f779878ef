//! A clip's feet and gait plotted over time, with what the detector of contacts weighed.

use super::numbers::grouped;
use super::output::Refusal;
use super::overview::there;
use crate::annotate::contacts::adaptive::evidence_height_m;
use crate::annotate::contacts::foot_paths::REFERENCE_LEG_M;
use crate::annotate::{Annotated, ContactSettings, Detector, Settings, annotate};
use crate::corpus::{Catalog, ClipRow, CorpusError, Manifest};
use crate::flow::noted_plan;
use crate::motion::kinematics::poses;
use crate::motion::{Poses, Role};
use crate::picture::{Plot, plot};
use std::path::Path;

/// A picture, what is on it, in words, and what is to be said beside it.
pub(super) struct Plotted {
    pub(super) svg: String,
    pub(super) words: String,
    pub(super) remark: Option<String>,
}

/// Plots the clip.
///
/// Log-odds and force are in a corpus only if it was told to keep them: all values are found anew, from the stored motion
/// by the settings of the corpus, which gives the labels that are stored.
pub(super) fn draw(row: &ClipRow, corpus: &Path, manifest: &Manifest, catalog: &Catalog) -> Result<Plotted, Refusal> {
    let plan = noted_plan(manifest);
    let remark = plan.is_none().then(|| {
        let name = corpus.display();
        format!("{name}: the plan that it was made by is not known; contacts are plotted by the default settings")
    });
    let settings =
        Settings { contacts: plan.map_or_else(Default::default, |plan| plan.config.contacts), diagnostics: true };
    let roles = &catalog.shard_of(row.clip_id)?.skeleton(row.clip_id)?.roles;
    let annotated = annotate(&stored_poses(row, catalog)?, roles, row.rate_hz, &settings);
    let Some(leg_length_m) = annotated.clip.leg_length_m else { return Err(without_feet(row, corpus)) };
    let has_toe = [Role::ToeLeft, Role::ToeRight].map(|toe| roles.get(toe).is_some());
    let mark = Marks::of(&settings.contacts, has_toe, f64::from(leg_length_m) / REFERENCE_LEG_M);
    let svg = plot(&Plot {
        name: &row.full_name(),
        facts: &facts(row, &annotated, settings.contacts.detector),
        rate_hz: row.rate_hz,
        labels: &annotated.frames,
        height_marks: mark.heights.each_ref().map(|(height_m, name)| Some((*height_m, name.as_str()))),
        speed_mark: mark.speed.as_ref().map(|(speed_mps, name)| (*speed_mps, name.as_str())),
    });
    let words = format!("{} frames, {:.2} s", grouped(u64::from(row.frames)), row.duration_s);
    Ok(Plotted { svg, words, remark })
}

/// Positions as annotation had them: those of the table `poses` are rounded, and are taken where there are no channels.
fn stored_poses(row: &ClipRow, catalog: &Catalog) -> Result<Poses, CorpusError> {
    let shard = catalog.shard_of(row.clip_id)?;
    match there(shard.motion(row.clip_id))? {
        Some(motion) => Ok(poses(&motion)),
        None => shard.poses(row.clip_id),
    }
}

fn without_feet(row: &ClipRow, corpus: &Path) -> Refusal {
    let (corpus, name) = (corpus.display(), row.full_name());
    Refusal::new(
        format!("{name}: no feet are known, so there is nothing to plot"),
        "heights, speeds, contacts and gait are those of feet, and both legs have to be known from hip to ankle",
        format!("motionmill inspect {corpus} {name} --raw lists joints and the roles that were found for them"),
    )
}

fn facts(row: &ClipRow, annotated: &Annotated, detector: Detector) -> String {
    let rate_hz = (row.rate_hz * 1000.0).round() / 1000.0;
    let length = format!("{} frames at {rate_hz} Hz, {:.2} s", grouped(u64::from(row.frames)), row.duration_s);
    let class = annotated.clip.gait_class.map_or("no class", |class| class.name());
    let confidence = annotated.clip.gait_confidence.map_or_else(String::new, |sure| format!(", confidence {sure:.2}"));
    format!("{length};  {class}{confidence};  detector: {}", detector.name())
}

/// Thresholds in the body's own size.
struct Marks {
    /// `[foot]`
    heights: [(f64, String); 2],
    speed: Option<(f64, String)>,
}

impl Marks {
    /// `has_toe`: `[foot]`; `scale`: metres a metre of the body that thresholds are meant for.
    fn of(settings: &ContactSettings, has_toe: [bool; 2], scale: f64) -> Marks {
        let (height_m, speed_mps) = match settings.detector {
            Detector::Adaptive => {
                let heights = has_toe.map(|has_toe| {
                    let height_m = evidence_height_m(has_toe) * scale;
                    (height_m, format!("evidence height, {height_m:.3} m"))
                });
                return Marks { heights, speed: None };
            }
            Detector::Thesis => (settings.thesis.max_height_m, settings.thesis.max_speed_mps),
            Detector::Extrema => (settings.extrema.max_height_m, settings.extrema.max_speed_mps),
        };
        let (height_m, speed_mps) = (height_m * scale, speed_mps * scale);
        Marks {
            heights: [0, 1].map(|_| (height_m, format!("threshold, {height_m:.3} m"))),
            speed: Some((speed_mps, format!("threshold, {speed_mps:.2} m/s"))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_foot_without_a_toe_has_the_mark_that_the_detector_goes_by() {
        let marks = Marks::of(&ContactSettings::default(), [true, false], 0.5);
        let expected = [(0.03, "evidence height, 0.030 m"), (0.06, "evidence height, 0.060 m")];
        assert_eq!(marks.heights.each_ref().map(|(height_m, name)| (*height_m, name.as_str())), expected);
        assert!(marks.speed.is_none());
        let fixed = ContactSettings { detector: Detector::Thesis, ..ContactSettings::default() };
        let marks = Marks::of(&fixed, [true, false], 2.0);
        assert!(marks.heights.iter().all(|(height_m, _)| *height_m == 0.1), "{:?}", marks.heights);
    }
}
