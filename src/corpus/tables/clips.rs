//! The `clips` table: one row a clip.

use crate::annotate::{ClipLabels, Gait};
use crate::corpus::columns::{Columns, METERS, PLAIN, SECONDS};
use crate::corpus::error::CorpusError;
use crate::corpus::rows::Rows;
use crate::corpus::tables::{RowTable, strings, texts};
use crate::motion::UpAxis;
use arrow::array::Array;
use serde::{Deserialize, Serialize};

/// What a clip was read from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[allow(missing_docs, reason = "as SCHEMA, clips.format")]
pub enum ClipFormat {
    Bvh,
    Amc,
    Made,
}

/// Where a clip comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[allow(missing_docs, reason = "as SCHEMA, clips.origin")]
pub enum Origin {
    Captured,
    Procedural,
    Graft,
    Transition,
    Loop,
    Mirror,
    Walk,
}

/// A row of `clips`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClipRow {
    /// Never given twice.
    pub clip_id: u32,
    /// Path below the input folder, without extension.
    pub name: String,
    /// Label of the source.
    pub source: String,
    /// What it was read from.
    pub format: ClipFormat,
    /// Id of the layout: which channels and poses dataset it is in.
    pub layout: String,
    /// Id of the skeleton.
    pub skeleton: String,
    /// Who moves, where that is known.
    pub subject: Option<String>,
    /// Number of frames.
    pub frames: u32,
    /// Frames a second, snapped.
    pub rate_hz: f64,
    /// As read; None: AMC, which has none.
    pub frame_time_s: Option<f64>,
    /// Frames over rate.
    pub duration_s: f64,
    /// Metres a file unit.
    pub unit_m: f64,
    /// Largest distance between a number of the file and its f32, file units.
    pub max_rounding: f32,
    /// Of the source; of all parents, where the clip was made.
    pub licenses: Vec<String>,
    /// Whom to name.
    pub attribution: Option<String>,
    /// Whether the license lets one pass it on. None: nobody said.
    pub may_share: Option<bool>,
    /// Whether the license lets one sell it. None: nobody said.
    pub may_sell: Option<bool>,
    /// Where it comes from.
    pub origin: Origin,
    /// clip_ids of what it was made from.
    pub parents: Vec<u32>,
    /// Name of the recipe it was made by.
    pub recipe: Option<String>,
    /// From leg length to checks.
    pub labels: ClipLabels,
    /// Warnings about it in `faults`.
    pub warnings: u32,
    /// Which axis of the file points up.
    pub up_axis: UpAxis,
}

impl ClipFormat {
    const ALL: [ClipFormat; 3] = [ClipFormat::Bvh, ClipFormat::Amc, ClipFormat::Made];

    /// The word in tables.
    pub fn name(self) -> &'static str {
        match self {
            ClipFormat::Bvh => "bvh",
            ClipFormat::Amc => "amc",
            ClipFormat::Made => "made",
        }
    }
}

impl Origin {
    const ALL: [Origin; 7] = [
        Origin::Captured,
        Origin::Procedural,
        Origin::Graft,
        Origin::Transition,
        Origin::Loop,
        Origin::Mirror,
        Origin::Walk,
    ];

    /// The word in tables.
    pub fn name(self) -> &'static str {
        match self {
            Origin::Captured => "captured",
            Origin::Procedural => "procedural",
            Origin::Graft => "graft",
            Origin::Transition => "transition",
            Origin::Loop => "loop",
            Origin::Mirror => "mirror",
            Origin::Walk => "walk",
        }
    }

    /// The origin of that name.
    pub fn from_name(name: &str) -> Option<Origin> {
        Origin::ALL.into_iter().find(|origin| origin.name() == name)
    }

    /// Whether the clip was made from others in the corpus; the tree, the graph and recipes leave those out.
    pub fn is_made(self) -> bool {
        !matches!(self, Origin::Captured | Origin::Procedural)
    }
}

impl ClipRow {
    /// `source/name`: what recipes call it by.
    pub fn full_name(&self) -> String {
        format!("{}/{}", self.source, self.name)
    }
}

const HERTZ: &[(&str, &str)] = &[("unit", "Hz")];
const FILE_UNITS: &[(&str, &str)] = &[("unit", "file"), ("space", "file")];
const RISE_OVER_RUN: &[(&str, &str)] = &[("unit", "m/m")];
const METERS_A_SECOND: &[(&str, &str)] = &[("unit", "m/s")];
const METERS_A_UNIT: &[(&str, &str)] = &[("unit", "m/file")];

impl RowTable for ClipRow {
    const NAME: &'static str = "clips";

    fn columns(rows: &[ClipRow]) -> Columns {
        let gait = |of: fn(&ClipLabels) -> Option<Gait>| rows.iter().map(move |row| of(&row.labels).map(Gait::name));
        macro_rules! label {
            ($name:ident) => {
                rows.iter().map(|row| row.labels.$name)
            };
        }
        Columns::new()
            .u32("clip_id", PLAIN, rows.iter().map(|row| row.clip_id))
            .str("name", rows.iter().map(|row| row.name.as_str()))
            .str("source", rows.iter().map(|row| row.source.as_str()))
            .str("format", rows.iter().map(|row| row.format.name()))
            .str("layout", rows.iter().map(|row| row.layout.as_str()))
            .str("skeleton", rows.iter().map(|row| row.skeleton.as_str()))
            .str_opt("subject", rows.iter().map(|row| row.subject.as_deref()))
            .u32("frames", PLAIN, rows.iter().map(|row| row.frames))
            .f64("rate_hz", HERTZ, rows.iter().map(|row| row.rate_hz))
            .f64_opt("frame_time_s", SECONDS, rows.iter().map(|row| row.frame_time_s))
            .f64("duration_s", SECONDS, rows.iter().map(|row| row.duration_s))
            .f64("unit_m", METERS_A_UNIT, rows.iter().map(|row| row.unit_m))
            .f32("max_rounding", FILE_UNITS, rows.iter().map(|row| row.max_rounding))
            .str_list("licenses", rows.iter().map(|row| row.licenses.as_slice()))
            .str_opt("attribution", rows.iter().map(|row| row.attribution.as_deref()))
            .bool_opt("may_share", rows.iter().map(|row| row.may_share))
            .bool_opt("may_sell", rows.iter().map(|row| row.may_sell))
            .str("origin", rows.iter().map(|row| row.origin.name()))
            .u32_list("parents", rows.iter().map(|row| row.parents.as_slice()))
            .str_opt("recipe", rows.iter().map(|row| row.recipe.as_deref()))
            .f32_opt("leg_length_m", METERS, label!(leg_length_m))
            .f32_opt("ground_height_m", METERS, label!(ground_height_m))
            .f32_opt("noise_m", METERS, label!(noise_m))
            .str_opt("gait_class", gait(|labels| labels.gait_class))
            .str_opt("thesis_class", gait(|labels| labels.thesis_class))
            .f32_opt("stand_fraction", PLAIN, label!(stand_fraction))
            .f32_opt("walk_fraction", PLAIN, label!(walk_fraction))
            .f32_opt("run_fraction", PLAIN, label!(run_fraction))
            .f32_opt("jump_fraction", PLAIN, label!(jump_fraction))
            .f32_opt("unknown_fraction", PLAIN, label!(unknown_fraction))
            .f32_opt("gait_confidence", PLAIN, label!(gait_confidence))
            .f32_opt("duty_factor", PLAIN, label!(duty_factor))
            .f32_opt("flight_fraction", PLAIN, label!(flight_fraction))
            .str_list("checks", rows.iter().map(|row| row.labels.checks.as_slice()))
            .u32("warnings", PLAIN, rows.iter().map(|row| row.warnings))
            .str("up_axis", rows.iter().map(|row| up_name(row.up_axis)))
            .f32_opt("leg_spread_m", METERS, label!(leg_spread_m))
            .f32_opt("ground_spread_m", METERS, label!(ground_spread_m))
            .f32_opt("ground_slope_x", RISE_OVER_RUN, label!(ground_slope_x))
            .f32_opt("ground_slope_z", RISE_OVER_RUN, label!(ground_slope_z))
            .f32_opt("ground_slope_share", PLAIN, label!(ground_slope_share))
            .bool_opt("uneven", label!(uneven))
            .f32_opt("belt_mps", METERS_A_SECOND, label!(belt_mps))
            .f32_opt("noise_spread_m", METERS, label!(noise_spread_m))
    }

    fn from_rows(rows: &Rows<'_>) -> Result<Vec<ClipRow>, CorpusError> {
        let clip_id = rows.u32("clip_id")?;
        let (name, source) = (texts(rows, "name")?, texts(rows, "source")?);
        let format = rows.str("format")?;
        let (layout, skeleton) = (texts(rows, "layout")?, texts(rows, "skeleton")?);
        let subject = strings(rows, "subject")?;
        let frames = rows.u32("frames")?;
        let (rate_hz, frame_time_s) = (rows.f64("rate_hz")?, rows.f64_opt("frame_time_s")?);
        let (duration_s, unit_m) = (rows.f64("duration_s")?, rows.f64("unit_m")?);
        let max_rounding = rows.f32("max_rounding")?;
        let (licenses, attribution) = (rows.str_lists("licenses")?, strings(rows, "attribution")?);
        let (may_share, may_sell) = (rows.bool_opt("may_share")?, rows.bool_opt("may_sell")?);
        let (origin, parents, recipe) = (rows.str("origin")?, rows.u32_lists("parents")?, strings(rows, "recipe")?);
        let (warnings, up_axis) = (rows.u32("warnings")?, rows.str("up_axis")?);
        let labels = labels(rows)?;
        (0..rows.len())
            .map(|at| {
                Ok(ClipRow {
                    clip_id: clip_id[at],
                    name: name[at].clone(),
                    source: source[at].clone(),
                    format: word(rows, format.value(at), &ClipFormat::ALL, ClipFormat::name)?,
                    layout: layout[at].clone(),
                    skeleton: skeleton[at].clone(),
                    subject: subject[at].clone(),
                    frames: frames[at],
                    rate_hz: rate_hz[at],
                    frame_time_s: frame_time_s.is_valid(at).then(|| frame_time_s.value(at)),
                    duration_s: duration_s[at],
                    unit_m: unit_m[at],
                    max_rounding: max_rounding[at],
                    licenses: licenses[at].clone(),
                    attribution: attribution[at].clone(),
                    may_share: may_share.is_valid(at).then(|| may_share.value(at)),
                    may_sell: may_sell.is_valid(at).then(|| may_sell.value(at)),
                    origin: word(rows, origin.value(at), &Origin::ALL, Origin::name)?,
                    parents: parents[at].clone(),
                    recipe: recipe[at].clone(),
                    labels: labels[at].clone(),
                    warnings: warnings[at],
                    up_axis: word(rows, up_axis.value(at), &[UpAxis::Y, UpAxis::Z], up_name)?,
                })
            })
            .collect()
    }
}

fn labels(rows: &Rows<'_>) -> Result<Vec<ClipLabels>, CorpusError> {
    let mut labels = vec![ClipLabels::default(); rows.len()];
    macro_rules! numbers {
        ($($name:ident)*) => {$(
            for (labels, value) in labels.iter_mut().zip(rows.f32_opt(stringify!($name))?) {
                labels.$name = value;
            }
        )*};
    }
    numbers!(leg_length_m leg_spread_m ground_height_m ground_spread_m ground_slope_x ground_slope_z ground_slope_share);
    numbers!(belt_mps noise_m noise_spread_m stand_fraction walk_fraction run_fraction jump_fraction unknown_fraction);
    numbers!(gait_confidence duty_factor flight_fraction);
    let gait = |word: Option<&str>| word.map(|word| super::gait(rows, word)).transpose();
    let (gait_class, thesis_class) = (rows.str_opt("gait_class")?, rows.str_opt("thesis_class")?);
    for (labels, (by_steps, by_thesis)) in labels.iter_mut().zip(gait_class.iter().zip(thesis_class)) {
        (labels.gait_class, labels.thesis_class) = (gait(by_steps)?, gait(by_thesis)?);
    }
    for (labels, uneven) in labels.iter_mut().zip(rows.bool_opt("uneven")?) {
        labels.uneven = uneven;
    }
    for (labels, checks) in labels.iter_mut().zip(rows.str_lists("checks")?) {
        labels.checks = checks;
    }
    Ok(labels)
}

fn word<T: Copy>(rows: &Rows<'_>, word: &str, all: &[T], name: fn(T) -> &'static str) -> Result<T, CorpusError> {
    let known = all.iter().copied().find(|&value| name(value) == word);
    known.ok_or_else(|| rows.damaged(format!("`{word}` is no word of this column")))
}

fn up_name(up: UpAxis) -> &'static str {
    match up {
        UpAxis::Y => "y",
        UpAxis::Z => "z",
    }
}
