//! The table of what a corpus holds: what a run ends with and `inspect` begins with.

use super::distrust::is_doubtful;
use super::numbers::{counted, grouped, grouped_text};
use crate::annotate::Gait;
use crate::annotate::checks::SURE;
use crate::corpus::{
    ClipRow, CorpusError, Manifest, Origin, Store, left_out, read_clips, read_edges, read_faults, read_made, read_nodes,
};
use serde::Serialize;
use std::collections::BTreeMap;

/// Clips, frames and hours of one kind.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(crate) struct Amount {
    pub(crate) clips: u64,
    pub(crate) frames: u64,
    pub(crate) hours: f64,
}

/// What a corpus holds.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(crate) struct Overview {
    /// `captured` or `procedural`.
    origin: String,
    captured: Amount,
    by_gait: BTreeMap<String, Amount>,
    /// Clips whose gait has a confidence below 0.8.
    doubtful: u64,
    without_feet: Amount,
    quarantined: u64,
    grafted: Amount,
    /// Whether recipes were counted and chosen.
    enriched: bool,
    recipes: u64,
    rejected: BTreeMap<String, u64>,
    product: String,
    nodes: u64,
    edges: u64,
    largest_component_share: f64,
    threshold_m2: Option<f64>,
    bytes: u64,
}

/// Gaits as the table shows them.
const ROWS: [&str; 5] = ["stand", "walk", "run", "jump", "other, unknown"];

impl Overview {
    /// Reads what there is.
    pub(crate) fn of(store: &Store, manifest: &Manifest) -> Result<Overview, CorpusError> {
        let mut overview = Overview { origin: "captured".to_owned(), ..Overview::default() };
        let clips = read_clips(store)?;
        for clip in &clips {
            if clip.origin.is_made() {
                overview.grafted.add(clip);
                continue;
            }
            if clip.origin == Origin::Procedural {
                overview.origin = "procedural".to_owned();
            }
            overview.captured.add(clip);
            let Some(gait) = clip.labels.gait_class else {
                overview.without_feet.add(clip);
                continue;
            };
            let row = match gait {
                Gait::Other | Gait::Unknown => ROWS[4],
                gait => gait.name(),
            };
            overview.by_gait.entry(row.to_owned()).or_default().add(clip);
            if is_doubtful(clip) {
                overview.doubtful += 1;
            }
        }
        let faults = there(read_faults(store))?.unwrap_or_default();
        overview.quarantined = left_out(manifest, &faults).len() as u64;
        overview.enriched = !manifest.products.is_empty();
        let sizes = manifest.products.values().filter_map(|size| size.parse::<u128>().ok());
        overview.product = sizes.sum::<u128>().to_string();
        for made in there(read_made(store))?.unwrap_or_default() {
            overview.recipes += 1;
            if let Some(reason) = made.reasons.first().filter(|_| !made.accepted) {
                *overview.rejected.entry(reason.clone()).or_default() += 1;
            }
        }
        if let Some(nodes) = there(read_nodes(store))? {
            let threshold = nodes.iter().map(|node| node.threshold).fold(f64::NEG_INFINITY, f64::max);
            let mut components = BTreeMap::<u32, u64>::new();
            let mut members = 0;
            for node in nodes.iter().filter(|node| node.threshold == threshold) {
                overview.nodes += 1;
                members += u64::from(node.members);
                *components.entry(node.component).or_default() += u64::from(node.members);
            }
            overview.largest_component_share =
                components.values().max().map_or(0.0, |largest| *largest as f64 / members.max(1) as f64);
            overview.threshold_m2 = threshold.is_finite().then_some(threshold);
            let first =
                nodes.iter().filter(|node| node.threshold == threshold).map(|node| node.node).min().unwrap_or(0);
            let last = nodes.iter().filter(|node| node.threshold == threshold).map(|node| node.node).max().unwrap_or(0);
            let here = |node: u32| (first..=last).contains(&node);
            let edges = there(read_edges(store))?.unwrap_or_default();
            overview.edges = edges.iter().filter(|edge| here(edge.from_node)).count() as u64;
        }
        overview.bytes = size_of(store)?;
        Ok(overview)
    }

    /// What was to be a clip and is none.
    pub(crate) fn quarantined(&self) -> u64 {
        self.quarantined
    }

    /// Bytes of all its files.
    pub(crate) fn bytes(&self) -> u64 {
        self.bytes
    }

    /// As a table. `corpus` is what the user calls it.
    pub(crate) fn text(&self, corpus: &str) -> String {
        let mut lines = vec![line("", "clips", "frames", "hours", "")];
        let mut row = |name: &str, amount: &Amount, remark: &str| {
            let hours = format!("{:.2}", amount.hours);
            lines.push(line(name, &grouped(amount.clips), &grouped(amount.frames), &hours, remark));
        };
        let doubtful = match self.doubtful {
            0 => String::new(),
            n => format!("confidence < {SURE}: {} (motionmill inspect {corpus} --doubtful)", counted(n, "clip")),
        };
        row(&self.origin, &self.captured, &doubtful);
        for name in ROWS {
            if let Some(amount) = self.by_gait.get(name) {
                row(&format!("  {name}"), amount, "");
            }
        }
        if self.without_feet.clips > 0 {
            let (name, remark) = match self.by_gait.is_empty() {
                true => ("  without gait", "the stages contacts and gait have not run, or found no feet"),
                false => ("  without feet", "joints not recognized: no contacts, no gait"),
            };
            row(name, &self.without_feet, remark);
        }
        if self.recipes > 0 || self.enriched {
            row("grafted", &self.grafted, &self.recipes_in_words());
        }
        if self.quarantined > 0 {
            let remark = format!("motionmill inspect {corpus} --faults");
            lines.push(line("quarantined", &grouped(self.quarantined), "", "", &remark));
        }
        if let Some(threshold) = self.threshold_m2 {
            lines.push(format!(
                "graph    {} nodes, {} edges; {:.0} % of the samples in one strongly connected component at T = {threshold} m²",
                grouped(self.nodes),
                grouped(self.edges),
                100.0 * self.largest_component_share
            ));
        }
        lines.join("\n")
    }

    fn recipes_in_words(&self) -> String {
        let rejected: u64 = self.rejected.values().sum();
        let of = format!("{} tried, of {} that could be made", grouped(self.recipes), grouped_text(&self.product));
        if rejected == 0 {
            return of;
        }
        let mut reasons: Vec<(&String, &u64)> = self.rejected.iter().collect();
        reasons.sort_by(|a, b| b.1.cmp(a.1).then(a.0.cmp(b.0)));
        let shown: Vec<String> = reasons.iter().take(3).map(|(reason, n)| format!("{reason} {n}")).collect();
        let more = if reasons.len() > 3 { ", ..." } else { "" };
        format!("{of}; {} rejected ({}{more})", grouped(rejected), shown.join(", "))
    }
}

/// A line of the table: numbers stand below each other.
fn line(name: &str, clips: &str, frames: &str, hours: &str, remark: &str) -> String {
    format!("  {name:<20}{clips:>9}{frames:>12}{hours:>8}     {remark}").trim_end().to_owned()
}

impl Amount {
    fn add(&mut self, clip: &ClipRow) {
        self.clips += 1;
        self.frames += u64::from(clip.frames);
        self.hours += clip.duration_s / 3600.0;
    }
}

/// A table that may not have been made yet.
pub(crate) fn there<T>(read: Result<T, CorpusError>) -> Result<Option<T>, CorpusError> {
    match read {
        Ok(rows) => Ok(Some(rows)),
        Err(CorpusError::NotThere { .. }) => Ok(None),
        Err(error) => Err(error),
    }
}

fn size_of(store: &Store) -> Result<u64, CorpusError> {
    let names = store.list("")?;
    Ok(names.iter().filter_map(|name| std::fs::metadata(store.path(name)).ok()).map(|file| file.len()).sum())
}
