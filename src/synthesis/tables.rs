//! Rows of the tables that enrichment writes (SCHEMA: recipes, made, provenance).

use serde::{Deserialize, Serialize};

/// One clip that could be made: all that making it again needs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Recipe {
    /// Its name, from its content.
    pub recipe: String,
    /// `graft`, later `transition`, `loop`, `mirror` ...
    pub kind: String,
    /// Name of the base clip, `source/name`.
    pub base: String,
    /// Name of the donor clip, `source/name`.
    pub donor: Option<String>,
    /// Chains taken from the donor.
    pub chains: Vec<String>,
    /// Which correlation, in the order of their cost from 0; None: the first that can be played.
    pub alternate: Option<i32>,
    /// Further options, JSON.
    pub options: String,
    /// Seed of whatever is random in it.
    pub seed: u64,
    /// Composition rule that allows it (T 5.4.2), such as `walk<-stand`.
    pub rule: String,
    /// Cell of (base legs, donor arms) that it fills (GRAFTS 8).
    pub cell: Option<String>,
}

/// What became of a recipe: accepted or not, and every judged figure beside its parents'.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Made {
    /// The recipe's name.
    pub recipe: String,
    /// None: rejected.
    pub clip_id: Option<u32>,
    /// Whether all gates let it through.
    pub accepted: bool,
    /// Gates that did not, or why it could not be made.
    pub reasons: Vec<String>,
    /// Base frames that carry the donor's motion: half-open.
    pub base_range: Option<[u32; 2]>,
    /// Donor frames used: half-open.
    pub donor_range: Option<[u32; 2]>,
    /// Every figure of GRAFTS 5, in its order.
    pub figures: Vec<Figure>,
}

/// One judged figure of a made clip beside the same figure of its parents.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "as SCHEMA, made: x, x_base, x_donor")]
pub struct Figure {
    pub name: String,
    pub own: Option<f32>,
    pub base: Option<f32>,
    pub donor: Option<f32>,
}

/// Where a part of a frame of a made clip comes from; where two parents blend, two rows.
#[derive(Clone, Debug, PartialEq)]
pub struct ProvenanceRow {
    /// Frame of the made clip.
    pub frame: u32,
    /// `root`, `legs`, `trunk`, `head`, `arm_left`, `arm_right` or `all`.
    pub part: &'static str,
    /// clip_id of the parent.
    pub parent: u32,
    /// Frame of the parent, fractional where it was resampled.
    pub parent_frame: f64,
    /// Weight of this parent, 0..1.
    pub weight: f32,
}

impl Recipe {
    /// The name that a recipe's content gives it: the same content, the same name, in any corpus.
    ///
    /// `seed`, `rule` and `cell` don't count: they say why it was chosen, not what it is.
    pub fn name_from_content(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        let alternate = self.alternate.map(|alternate| alternate.to_string());
        let donor = self.donor.as_deref();
        let texts = [Some(&*self.kind), Some(&*self.base), donor, alternate.as_deref(), Some(&*self.options)];
        for text in texts.into_iter().chain(self.chains.iter().map(|chain| Some(&**chain))) {
            hasher.update(&(text.map_or(-1, |text| text.len() as i64)).to_le_bytes());
            hasher.update(text.unwrap_or_default().as_bytes());
        }
        format!("{}-{}", self.kind, hasher.finalize().to_hex().split_at(12).0)
    }
}
