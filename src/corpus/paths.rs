//! Where things lie in a corpus folder (SCHEMA). Names are relative, with `/` on every system.

use crate::annotate::PlantState;
use serde::{Deserialize, Serialize};

/// The manifest.
pub const MANIFEST: &str = "manifest.json";
/// The dataset card.
pub const CARD: &str = "README.md";
/// The folder of commit records.
pub const COMMITS: &str = "commits";
/// The `clips` table.
pub const CLIPS: &str = "clips.parquet";
/// The `skeletons` table.
pub const SKELETONS: &str = "skeletons.parquet";
/// The `faults` table.
pub const FAULTS: &str = "faults.parquet";
/// The `nodes` table.
pub const NODES: &str = "nodes.parquet";
/// The `sequences` table.
pub const SEQUENCES: &str = "sequences.parquet";
/// The `edges` table.
pub const EDGES: &str = "edges.parquet";
/// The `recipes` table.
pub const RECIPES: &str = "recipes.parquet";
/// The `made` table.
pub const MADE: &str = "made.parquet";
/// What the judge holds made clips against, frozen by the first enrichment.
pub const REFERENCE: &str = "reference.json";

/// A table that is written shard by shard.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[allow(missing_docs, reason = "as SCHEMA")]
pub enum Table {
    Channels,
    Poses,
    Annotations,
    Features,
    Plants,
    Segments,
    Provenance,
}

/// What is made, skipped and made anew together: each has its key in a commit record.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ShardStage {
    /// Channels, poses, and for made clips provenance. Without it there is no shard.
    Ingest,
    /// Features.
    Features,
    /// Annotations, plants, segments, and the labels in the clip rows.
    Labels,
}

/// Whether a shard holds clips that were read or clips that were made here.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ShardKind {
    /// Captured or procedural clips: `shard-00000`.
    Captured,
    /// Made clips: `made-00000`.
    Made,
}

/// A unit of work and of output: a fixed list of clips (DESIGN 4).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub struct ShardId {
    /// Which series.
    pub kind: ShardKind,
    /// From 0, never given twice in a corpus.
    pub number: u32,
}

impl Table {
    /// All of them, in SCHEMA's order.
    pub const ALL: [Table; 7] = [
        Table::Channels,
        Table::Poses,
        Table::Annotations,
        Table::Features,
        Table::Plants,
        Table::Segments,
        Table::Provenance,
    ];

    /// Name of the table and its folder.
    pub fn name(self) -> &'static str {
        match self {
            Table::Channels => "channels",
            Table::Poses => "poses",
            Table::Annotations => "annotations",
            Table::Features => "features",
            Table::Plants => "plants",
            Table::Segments => "segments",
            Table::Provenance => "provenance",
        }
    }

    /// The table of that name.
    pub fn from_name(name: &str) -> Option<Table> {
        Table::ALL.into_iter().find(|table| table.name() == name)
    }

    /// Whether its columns depend on the skeleton's layout, so that there is one dataset a layout.
    pub fn by_layout(self) -> bool {
        matches!(self, Table::Channels | Table::Poses)
    }

    /// With what it is made anew.
    pub fn stage(self) -> ShardStage {
        match self {
            Table::Channels | Table::Poses | Table::Provenance => ShardStage::Ingest,
            Table::Features => ShardStage::Features,
            Table::Annotations | Table::Plants | Table::Segments => ShardStage::Labels,
        }
    }

    /// The table that a file of a corpus belongs to, if it is a sharded one's.
    pub fn of_file(name: &str) -> Option<Table> {
        name.split_once('/').and_then(|(folder, _)| Table::from_name(folder))
    }
}

impl ShardId {
    /// A shard of captured or procedural clips.
    pub fn captured(number: u32) -> ShardId {
        ShardId { kind: ShardKind::Captured, number }
    }

    /// A shard of made clips.
    pub fn made(number: u32) -> ShardId {
        ShardId { kind: ShardKind::Made, number }
    }

    /// The shard of that name, such as `shard-00012`.
    pub fn from_name(name: &str) -> Option<ShardId> {
        let (kind, digits) = match name.split_once('-')? {
            ("shard", digits) => (ShardKind::Captured, digits),
            ("made", digits) => (ShardKind::Made, digits),
            _ => return None,
        };
        let shard = ShardId { kind, number: digits.parse().ok()? };
        (shard.to_string() == name).then_some(shard)
    }

    /// File of a table; the layout is used where the table has one dataset a layout.
    pub fn file(self, table: Table, layout: &str) -> String {
        match table.by_layout() {
            true => format!("{}/layout={layout}/{self}.parquet", table.name()),
            false => format!("{}/{self}.parquet", table.name()),
        }
    }

    /// File of the commit record.
    pub fn record_file(self) -> String {
        format!("{COMMITS}/{self}.json")
    }

    /// The shard that a file of a sharded table, or a record, belongs to.
    pub fn of_file(name: &str) -> Option<ShardId> {
        let (folder, file) = name.rsplit_once('/')?;
        let stem = match folder == COMMITS {
            true => file.strip_suffix(".json")?,
            false => Table::of_file(name).and_then(|_| file.strip_suffix(".parquet"))?,
        };
        ShardId::from_name(stem)
    }
}

impl std::fmt::Display for ShardId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let series = match self.kind {
            ShardKind::Captured => "shard",
            ShardKind::Made => "made",
        };
        write!(f, "{series}-{:05}", self.number)
    }
}

impl From<ShardId> for String {
    fn from(shard: ShardId) -> String {
        shard.to_string()
    }
}

impl TryFrom<String> for ShardId {
    type Error = String;

    fn try_from(name: String) -> Result<ShardId, String> {
        ShardId::from_name(&name).ok_or_else(|| format!("`{name}` is not the name of a shard"))
    }
}

/// Whether a name is one that this program gives to a file of a corpus, so that it may be cleared away.
pub(super) fn is_ours(name: &str) -> bool {
    let whole = [MANIFEST, CARD, CLIPS, SKELETONS, FAULTS, NODES, SEQUENCES, EDGES, RECIPES, MADE, REFERENCE];
    let tree = |folder: &str| name.strip_prefix(folder).is_some_and(|rest| rest.contains("plant_state="));
    whole.contains(&name) || ShardId::of_file(name).is_some() || tree("items/tree=") || tree("merges/tree=")
}

/// The folders that such files lie in.
pub(super) fn our_folders() -> impl Iterator<Item = &'static str> {
    [COMMITS, "items", "merges"].into_iter().chain(Table::ALL.map(Table::name))
}

/// File of a tree's items in one plant state.
pub fn items_file(tree: &str, state: PlantState) -> String {
    format!("items/tree={tree}/plant_state={}.parquet", state.name())
}

/// File of a tree's merges in one plant state.
pub fn merges_file(tree: &str, state: PlantState) -> String {
    format!("merges/tree={tree}/plant_state={}/part-00000.parquet", state.name())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_says_its_shard_and_table() {
        let shard = ShardId::made(123_456);
        for table in Table::ALL {
            let file = shard.file(table, "L0123abcd");
            assert_eq!(ShardId::of_file(&file), Some(shard), "{file}");
            assert_eq!(Table::of_file(&file), Some(table), "{file}");
        }
        assert_eq!(ShardId::of_file(&shard.record_file()), Some(shard));
        assert_eq!(ShardId::captured(7).file(Table::Poses, "L1"), "poses/layout=L1/shard-00007.parquet");
        assert!(is_ours(&items_file("body", PlantState::N)) && is_ours(&merges_file("legs", PlantState::LB)));
        for foreign in
            ["clips.parquet", "poses/layout=L1/mine.parquet", "poses/shard-1.parquet", "x/shard-00001.parquet"]
        {
            assert_eq!(ShardId::of_file(foreign), None, "{foreign}");
            assert_eq!(is_ours(foreign), foreign == CLIPS, "{foreign}");
        }
    }
}
