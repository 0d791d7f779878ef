//! All about one clip.

use super::distrust::checks_of;
use super::faults;
use super::made::{figures, figures_json};
use super::numbers::{counted, grouped};
use super::output::Refusal;
use super::overview::there;
use super::search::clip_json;
use super::table::{Side, Table};
use super::timeline::timeline;
use crate::annotate::{Foot, Gait, Plant, Segment};
use crate::corpus::{Catalog, ClipRow, FaultRow, Store, read_made, read_recipes};
use crate::motion::UpAxis;
use crate::synthesis::{Made, Recipe};
use serde_json::{Value, json};

/// What the corpus knows of a clip.
pub(super) struct ClipPage<'a> {
    row: &'a ClipRow,
    n_joints: usize,
    n_channels: usize,
    is_labelled: bool,
    /// Clips of the same skeleton, this one too.
    n_same_skeleton: usize,
    parents: Vec<String>,
    children: Vec<String>,
    segments: Vec<Segment>,
    plants: Vec<Plant>,
    faults: Vec<FaultRow>,
    recipe: Option<Recipe>,
    made: Option<Made>,
}

/// Clips made of this one that are named.
const NAMED: usize = 4;
/// Segments and plants that have a line.
const LINES: usize = 40;

impl<'a> ClipPage<'a> {
    /// Reads what there is; tables that have not been made are left out.
    pub(super) fn read(
        row: &'a ClipRow,
        clips: &[ClipRow],
        faults: Vec<FaultRow>,
        store: &Store,
        catalog: &Catalog,
    ) -> Result<ClipPage<'a>, Refusal> {
        let shard = catalog.shard_of(row.clip_id)?;
        let body = &shard.skeleton(row.clip_id)?.body;
        let name_of = |id: &u32| {
            let parent = clips.iter().find(|clip| clip.clip_id == *id);
            parent.map_or_else(|| format!("clip {id}, which has gone"), ClipRow::full_name)
        };
        let (mut recipe, mut made) = (None, None);
        if let Some(name) = &row.recipe {
            let recipes = there(read_recipes(store))?.unwrap_or_default();
            recipe = recipes.into_iter().find(|recipe| recipe.recipe == *name);
            made = there(read_made(store))?.unwrap_or_default().into_iter().find(|made| made.recipe == *name);
        }
        Ok(ClipPage {
            row,
            n_joints: body.joints.len(),
            n_channels: body.n_channels(),
            is_labelled: !shard.record().keys.labels.is_empty(),
            n_same_skeleton: clips.iter().filter(|clip| clip.skeleton == row.skeleton).count(),
            parents: row.parents.iter().map(name_of).collect(),
            children: clips.iter().filter(|clip| clip.parents.contains(&row.clip_id)).map(ClipRow::full_name).collect(),
            segments: there(shard.segments(row.clip_id))?.unwrap_or_default(),
            plants: there(shard.plants(row.clip_id))?.unwrap_or_default(),
            faults,
            recipe,
            made,
        })
    }

    /// For people.
    pub(super) fn text(&self) -> String {
        let row = self.row;
        let mut text = format!("{}\n", row.full_name());
        let mut line = |word: &str, words: String| text.push_str(&format!("{word:<11}{words}\n"));
        line("clip", self.what_it_is());
        line(
            "skeleton",
            format!(
                "{}: {} joints, {} channels, 1 unit = {} m, {} up; {} of it",
                row.skeleton,
                self.n_joints,
                self.n_channels,
                (row.unit_m * 1e6).round() / 1e6,
                if row.up_axis == UpAxis::Z { "Z" } else { "Y" },
                counted(self.n_same_skeleton as u64, "clip")
            ),
        );
        if !row.licenses.is_empty() || row.attribution.is_some() {
            let attribution = row.attribution.iter().map(|words| format!("; {words}")).collect::<String>();
            line("license", format!("{}{attribution}", row.licenses.join(", ")));
        }
        line("gait", self.gait());
        let ground = self.ground();
        if !ground.is_empty() {
            line("ground", ground);
        }
        line("checks", checks_of(row));
        if let Some(recipe) = &self.recipe {
            line("recipe", format!("{}, {}, {}", recipe.recipe, recipe.rule, recipe.chains.join(" + ")));
            let names = ["base", "donor"].iter().zip(&self.parents);
            let range = |at: usize| {
                let made = self.made.as_ref()?;
                let [first, end] = if at == 0 { made.base_range? } else { made.donor_range? };
                Some(format!(", frames {first} to {end}"))
            };
            for (at, (word, parent)) in names.enumerate() {
                line(word, format!("{parent}{}", range(at).unwrap_or_default()));
            }
        }
        if !self.children.is_empty() {
            let more = if self.children.len() > NAMED { ", ..." } else { "" };
            let named: Vec<&str> = self.children.iter().take(NAMED).map(String::as_str).collect();
            let count = counted(self.children.len() as u64, "clip");
            line("parent of", format!("{count}: {}{more}", named.join(", ")));
        }
        text.push_str(&self.time());
        if let Some(made) = &self.made {
            let verdict = match (made.accepted, made.reasons.as_slice()) {
                (true, _) => "accepted".to_owned(),
                (false, reasons) => format!("rejected: {}", reasons.join(", ")),
            };
            text.push_str(&format!("\nverdict    {verdict}\n{}", figures(&made.figures)));
        }
        if !self.faults.is_empty() {
            text.push_str(&format!("\n{}", faults::text(&self.faults).trim_end()));
            text.push('\n');
        }
        text
    }

    /// For programs: the columns of `clips`, and below them what belongs to the clip.
    pub(super) fn json(&self) -> Value {
        let range = |first: u32, end: u32| json!([first, end]);
        let mut value = clip_json(self.row);
        value["parent_names"] = json!(self.parents);
        value["parent_of"] = json!(self.children);
        value["segments"] = self
            .segments
            .iter()
            .map(|segment| {
                json!({"gait": segment.gait.name(), "frames": range(segment.first, segment.end),
                    "confidence": segment.confidence})
            })
            .collect();
        value["plants"] = self
            .plants
            .iter()
            .map(|plant| {
                json!({"foot": plant.foot.name(), "frames": range(plant.first, plant.end),
                    "position": plant.position, "slip_m": plant.slip_m, "confidence": plant.confidence})
            })
            .collect();
        value["faults"] = faults::json(&self.faults);
        value["made"] = self.made.as_ref().map_or(Value::Null, |made| {
            json!({"accepted": made.accepted, "reasons": made.reasons, "recipe": self.recipe,
                "base_range": made.base_range, "donor_range": made.donor_range, "figures": figures_json(&made.figures)})
        });
        value
    }

    fn what_it_is(&self) -> String {
        let row = self.row;
        let format = if row.origin.is_made() { row.origin.name() } else { row.format.name() };
        let subject = row.subject.iter().map(|subject| format!(", {subject}")).collect::<String>();
        let procedural = if row.origin == crate::corpus::Origin::Procedural { ", procedural" } else { "" };
        format!(
            "{format}{procedural}{subject}, {} frames at {} Hz, {:.2} s",
            grouped(u64::from(row.frames)),
            (row.rate_hz * 1000.0).round() / 1000.0,
            row.duration_s
        )
    }

    fn gait(&self) -> String {
        let labels = &self.row.labels;
        let Some(class) = labels.gait_class else {
            let why = match self.is_labelled {
                true => "feet were not recognized among the joints",
                false => "the stages contacts and gait have not run",
            };
            return format!("none: {why}");
        };
        let shares = [
            ("stand", labels.stand_fraction),
            ("walk", labels.walk_fraction),
            ("run", labels.run_fraction),
            ("jump", labels.jump_fraction),
            ("unknown", labels.unknown_fraction),
        ];
        let shares = shares.iter().filter_map(|(word, share)| Some((word, (*share).filter(|share| *share > 0.0)?)));
        let shares: Vec<String> = shares.map(|(word, share)| format!("{word} {:.0} %", share * 100.0)).collect();
        let mut words = vec![class.name().to_owned(), shares.join(" ")];
        words.extend(labels.gait_confidence.map(|sure| format!("confidence {sure:.2}")));
        words.extend(labels.duty_factor.map(|duty| format!("duty factor {duty:.2}")));
        words.extend(labels.flight_fraction.map(|flight| format!("in flight {:.0} %", flight * 100.0)));
        words.extend(labels.leg_length_m.map(|leg| format!("leg {leg:.2} m")));
        words.extend(labels.thesis_class.map(|class| format!("thesis: {}", class.name())));
        words.join(", ")
    }

    /// What the feet rest on, and how well it is known; empty where it is not.
    fn ground(&self) -> String {
        let labels = &self.row.labels;
        let mut words: Vec<String> = Vec::new();
        words.extend(labels.ground_height_m.map(|height| {
            let spread = labels.ground_spread_m.map_or(String::new(), |spread| format!(" ± {spread:.3}"));
            format!("at {height:.3}{spread} m")
        }));
        words.extend(match (labels.ground_slope_x, labels.ground_slope_z, labels.ground_slope_share) {
            (Some(x), Some(z), Some(share)) => {
                let slope = f64::from(x * x + z * z).sqrt();
                Some(format!(
                    "slope {:.1} % ({:.0} % of the resting toes are on that plane)",
                    100.0 * slope,
                    100.0 * share
                ))
            }
            _ => None,
        });
        if labels.uneven == Some(true) {
            words.push("uneven: each plant has its own level".to_owned());
        }
        words.extend(labels.belt_mps.filter(|&belt| belt > 0.0).map(|belt| format!("a belt at {belt:.2} m/s")));
        words.extend(labels.noise_m.map(|noise| format!("noise {:.1} mm", noise * 1000.0)));
        words.join(", ")
    }

    /// The time line, and a line a plant.
    fn time(&self) -> String {
        let row = self.row;
        if self.segments.is_empty() && self.plants.is_empty() {
            return String::new();
        }
        let line = timeline(row.frames as usize, &self.segments, &self.plants);
        let end = format!("{:.2} s", row.duration_s);
        let width = line.gait.chars().count().saturating_sub(end.len()).max(2);
        let letters = "S stand  W walk  R run  J jump  ? unknown  _ planted";
        let mut text = format!(
            "\n           {:<width$}{end}\n  gait     {}\n  left     {}\n  right    {}\n           {letters}\n",
            "0",
            line.gait,
            line.left.trim_end(),
            line.right.trim_end()
        );
        text.push_str(&self.segment_table());
        text.push_str(&self.plant_table());
        text
    }

    fn segment_table(&self) -> String {
        let mut table = Table::new(&[
            ("gait", Side::Left),
            ("from s", Side::Right),
            ("to s", Side::Right),
            ("frames", Side::Right),
            ("confidence", Side::Right),
        ]);
        for segment in self.segments.iter().take(LINES) {
            table.row([
                segment.gait.name().to_owned(),
                self.seconds(segment.first),
                self.seconds(segment.end),
                format!("{}-{}", segment.first, segment.end),
                two_digits(segment.confidence.filter(|_| segment.gait != Gait::Unknown)),
            ]);
        }
        listed(&table, self.segments.len())
    }

    fn plant_table(&self) -> String {
        let mut table = Table::new(&[
            ("plant", Side::Left),
            ("from s", Side::Right),
            ("to s", Side::Right),
            ("frames", Side::Right),
            ("slip mm", Side::Right),
            ("confidence", Side::Right),
        ]);
        let mut plants: Vec<&Plant> = self.plants.iter().collect();
        plants.sort_by_key(|plant| (plant.first, plant.foot));
        for plant in plants.into_iter().take(LINES) {
            table.row([
                if plant.foot == Foot::Left { "left" } else { "right" }.to_owned(),
                self.seconds(plant.first),
                self.seconds(plant.end),
                format!("{}-{}", plant.first, plant.end),
                format!("{:.0}", plant.slip_m * 1000.0),
                two_digits(plant.confidence),
            ]);
        }
        listed(&table, self.plants.len())
    }

    fn seconds(&self, frame: u32) -> String {
        format!("{:.2}", f64::from(frame) / self.row.rate_hz)
    }
}

/// A table of a part of the rows that there are.
fn listed(table: &Table, n_rows: usize) -> String {
    let more = match n_rows.saturating_sub(LINES) as u64 {
        0 => String::new(),
        n => format!("  ... and {} more (--json lists all)\n", grouped(n)),
    };
    if table.is_empty() { String::new() } else { format!("\n{}{more}", table.text()) }
}

fn two_digits(value: Option<f32>) -> String {
    value.map_or(String::new(), |value| format!("{value:.2}"))
}
