//! The `annotations` table: what happens in every frame.

use super::expect_frames;
use crate::annotate::{FrameDiagnostics, FrameLabels, Gait, PlantState};
use crate::corpus::columns::{Columns, METERS, METERS_WORLD, PLAIN, SECONDS};
use crate::corpus::error::CorpusError;
use crate::corpus::rows::Rows;

const SPEED: &[(&str, &str)] = &[("unit", "m/s")];
const RADIANS_WORLD: &[(&str, &str)] = &[("unit", "rad"), ("space", "world")];
const RADIANS_PER_SECOND: &[(&str, &str)] = &[("unit", "rad/s")];
const HEIGHTS: [&str; 4] = ["left_ankle_height", "left_toe_height", "right_ankle_height", "right_toe_height"];
const SPEEDS: [&str; 4] = ["left_ankle_speed", "left_toe_speed", "right_ankle_speed", "right_toe_speed"];
const STANCES: [&str; 2] = ["left_stance", "right_stance"];
const PINNED: [&str; 2] = ["left_pinned", "right_pinned"];
const LOG_ODDS: [&str; 2] = ["left_log_odds", "right_log_odds"];
const FORCE: &str = "force";
const GROUND: [&str; 2] = ["left_ground", "right_ground"];
const BODY_WEIGHTS: &[(&str, &str)] = &[("unit", "body weight")];

/// Gathers a clip's labels.
#[derive(Debug, Default)]
pub(in crate::corpus) struct GatherLabels(FrameLabels);

/// Columns of one clip's labels.
pub(in crate::corpus) fn annotations_columns(clip_id: u32, labels: &FrameLabels) -> Columns {
    let n = labels.time_s.len();
    let mut columns = Columns::new()
        .u32("clip_id", PLAIN, std::iter::repeat_n(clip_id, n))
        .u32("frame", PLAIN, 0..n as u32)
        .f64("time_s", SECONDS, labels.time_s.iter().copied());
    for (axis, name) in ["root_x", "root_y", "root_z"].into_iter().enumerate() {
        columns = columns.f32(name, METERS_WORLD, labels.root.iter().map(|root| root[axis]));
    }
    columns = columns
        .f32_opt("heading", RADIANS_WORLD, labels.heading.iter().copied())
        .f32("speed", SPEED, labels.speed.iter().copied())
        .f32_opt("turn_rate", RADIANS_PER_SECOND, labels.turn_rate.iter().copied());
    for (name, values) in HEIGHTS.into_iter().zip(&labels.heights) {
        columns = columns.f32_opt(name, METERS, values.iter().copied());
    }
    for (name, values) in SPEEDS.into_iter().zip(&labels.speeds) {
        columns = columns.f32_opt(name, SPEED, values.iter().copied());
    }
    for (name, values) in STANCES.into_iter().zip(&labels.stance).chain(PINNED.into_iter().zip(&labels.pinned)) {
        columns = columns.bool_opt(name, values.iter().copied());
    }
    columns = columns
        .str_opt("plant_state", labels.plant_state.iter().map(|state| state.map(PlantState::name)))
        .str_opt("gait", labels.gait.iter().map(|gait| gait.map(Gait::name)))
        .f32_opt("gait_confidence", PLAIN, labels.gait_confidence.iter().copied())
        .f32_opt("phase", PLAIN, labels.phase.iter().copied());
    if let Some(FrameDiagnostics { log_odds, force, ground }) = &labels.diagnostics {
        for (name, values) in LOG_ODDS.into_iter().zip(log_odds) {
            columns = columns.f32_opt(name, PLAIN, values.iter().copied());
        }
        columns = columns.f32_opt(FORCE, BODY_WEIGHTS, force.iter().copied());
        for (name, values) in GROUND.into_iter().zip(ground) {
            columns = columns.f32_opt(name, METERS_WORLD, values.iter().copied());
        }
    }
    columns
}

impl GatherLabels {
    /// What is wrong with a clip's labels, if anything.
    pub(in crate::corpus) fn refuse(labels: &FrameLabels, n_frames: usize) -> Result<(), String> {
        let optional = [&labels.heading, &labels.turn_rate, &labels.gait_confidence, &labels.phase];
        let optional: Vec<&Vec<Option<f32>>> =
            optional.into_iter().chain(&labels.heights).chain(&labels.speeds).chain(diagnostics(labels)).collect();
        let mut lengths = vec![labels.time_s.len(), labels.root.len(), labels.speed.len()];
        lengths.extend([labels.plant_state.len(), labels.gait.len()]);
        lengths.extend(optional.iter().map(|values| values.len()));
        lengths.extend(labels.stance.iter().chain(&labels.pinned).map(Vec::len));
        if let Some(length) = lengths.iter().find(|&&length| length != n_frames) {
            return Err(format!("a column of {length} values for {n_frames} frames"));
        }
        let finite = labels.time_s.iter().all(|value| value.is_finite())
            && labels.root.iter().flatten().chain(&labels.speed).all(|value| value.is_finite())
            && optional.into_iter().flatten().flatten().all(|value| value.is_finite());
        if finite { Ok(()) } else { Err("a number that isn't finite".to_owned()) }
    }
}

/// Columns of the diagnostics, if there are any.
fn diagnostics(labels: &FrameLabels) -> impl Iterator<Item = &Vec<Option<f32>>> {
    labels.diagnostics.iter().flat_map(|shown| shown.log_odds.iter().chain([&shown.force]).chain(&shown.ground))
}

impl crate::corpus::reader::Gather for GatherLabels {
    /// None: the table has no rows of the clip.
    type Clip = Option<FrameLabels>;

    fn gather(&mut self, rows: &Rows<'_>) -> Result<(), CorpusError> {
        let labels = &mut self.0;
        expect_frames(rows, labels.time_s.len())?;
        labels.time_s.extend(rows.f64("time_s")?);
        let (x, y, z) = (rows.f32("root_x")?, rows.f32("root_y")?, rows.f32("root_z")?);
        labels.root.extend((0..rows.len()).map(|row| [x[row], y[row], z[row]]));
        labels.heading.extend(rows.f32_opt("heading")?);
        labels.speed.extend(rows.f32("speed")?);
        labels.turn_rate.extend(rows.f32_opt("turn_rate")?);
        for (name, values) in HEIGHTS.into_iter().zip(&mut labels.heights) {
            values.extend(rows.f32_opt(name)?);
        }
        for (name, values) in SPEEDS.into_iter().zip(&mut labels.speeds) {
            values.extend(rows.f32_opt(name)?);
        }
        let feet = STANCES.into_iter().zip(&mut labels.stance).chain(PINNED.into_iter().zip(&mut labels.pinned));
        for (name, values) in feet {
            values.extend(rows.bool_opt(name)?);
        }
        for word in rows.str_opt("plant_state")? {
            let state = word.map(|word| {
                PlantState::from_name(word).ok_or_else(|| rows.damaged(format!("`{word}` is no plant state")))
            });
            labels.plant_state.push(state.transpose()?);
        }
        for word in rows.str_opt("gait")? {
            labels.gait.push(word.map(|word| super::gait(rows, word)).transpose()?);
        }
        labels.gait_confidence.extend(rows.f32_opt("gait_confidence")?);
        labels.phase.extend(rows.f32_opt("phase")?);
        if rows.has(FORCE) {
            let shown = labels.diagnostics.get_or_insert_default();
            for (name, values) in LOG_ODDS.into_iter().zip(&mut shown.log_odds) {
                values.extend(rows.f32_opt(name)?);
            }
            shown.force.extend(rows.f32_opt(FORCE)?);
            for (name, values) in GROUND.into_iter().zip(&mut shown.ground) {
                values.extend(rows.f32_opt(name)?);
            }
        }
        Ok(())
    }

    fn done(self) -> Option<FrameLabels> {
        (!self.0.time_s.is_empty()).then_some(self.0)
    }
}
