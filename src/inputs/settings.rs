//! What a user says about folders and clips that the files themselves don't say: rate, unit, axis, license.

use super::pattern::matches;
use crate::motion::UpAxis;
use crate::motion::skeleton::PositionRule;
use serde::{Deserialize, Serialize};

/// What holds for every input folder, unless a source or a clip says otherwise.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct InputSettings {
    /// Clips to leave out: names or last components of names, `*` stands for anything.
    pub skip: Vec<String>,
    /// Frames a second. None: what the file says; AMC, which says nothing, 120.
    pub rate_hz: Option<f64>,
    /// Metres a file unit. None: what the file says, or a guess by the size of the body.
    pub unit_m: Option<f64>,
    /// Axis that points up. None: a guess by the way the body stands.
    pub up: Option<UpAxis>,
    /// What position channels of inner joints do to their offsets: replace or add.
    pub position_channels: PositionRule,
}

/// What holds for one input folder. The first rule whose `folder` fits is the one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SourceRule {
    /// Name of the source in the tables. None: the folder's name.
    pub label: Option<String>,
    /// Name of the input folder, or the end of its path with `/`; `*` stands for anything.
    pub folder: String,
    /// Frames a second.
    pub rate_hz: Option<f64>,
    /// Metres a file unit.
    pub unit_m: Option<f64>,
    /// Axis that points up.
    pub up: Option<UpAxis>,
    /// What position channels of inner joints do to their offsets.
    pub position_channels: Option<PositionRule>,
    /// ASF for AMC files that find none by name, from the input folder.
    pub asf: Option<String>,
    /// License of the clips, a short name or identifier.
    pub license: Option<String>,
    /// Words that the license asks for.
    pub attribution: Option<String>,
    /// Whether clips may be passed on.
    pub may_share: Option<bool>,
    /// Whether clips may be used or sold commercially.
    pub may_sell: Option<bool>,
    /// Clips must not become parents of new ones.
    pub no_derivatives: bool,
}

/// What holds for clips by name, over what their source says. Every rule that fits counts, the later ones over the earlier.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClipRule {
    /// Clip name or its last component, `*` stands for anything.
    pub name: String,
    /// Only clips of this source.
    pub source: Option<String>,
    /// Frames a second.
    pub rate_hz: Option<f64>,
    /// Metres a file unit.
    pub unit_m: Option<f64>,
    /// Axis that points up.
    pub up: Option<UpAxis>,
    /// What position channels of inner joints do to their offsets.
    pub position_channels: Option<PositionRule>,
    /// Its ASF, from the input folder.
    pub asf: Option<String>,
    /// Who performs it.
    pub subject: Option<String>,
    /// License, where it differs from the source's.
    pub license: Option<String>,
    /// Words that the license asks for.
    pub attribution: Option<String>,
    /// Whether it may be passed on.
    pub may_share: Option<bool>,
    /// Whether it may be used or sold commercially.
    pub may_sell: Option<bool>,
    /// Must not become a parent of new clips.
    pub no_derivatives: Option<bool>,
}

/// All rules about inputs, in the order of the config.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InputRules {
    /// For every folder.
    pub inputs: InputSettings,
    /// By folder.
    pub sources: Vec<SourceRule>,
    /// By clip.
    pub clips: Vec<ClipRule>,
}

/// What the rules come to for one clip. Part of the clip's key.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SourceSettings {
    /// Frames a second; None: as the file says, or a guess.
    pub rate_hz: Option<f64>,
    /// Metres a file unit; None: as the file says, or a guess.
    pub unit_m: Option<f64>,
    /// Axis that points up; None: a guess.
    pub up: Option<UpAxis>,
    /// What position channels of inner joints do to their offsets.
    pub position_channels: PositionRule,
    /// Who performs it.
    pub subject: Option<String>,
    /// License of the clip.
    pub license: Option<String>,
    /// Words that the license asks for.
    pub attribution: Option<String>,
    /// Whether the clip may be passed on; None: not known.
    pub may_share: Option<bool>,
    /// Whether it may be used or sold commercially; None: not known.
    pub may_sell: Option<bool>,
    /// Must not become a parent of new clips.
    pub no_derivatives: bool,
}

impl Default for SourceRule {
    fn default() -> Self {
        SourceRule {
            label: None,
            folder: "*".to_owned(),
            rate_hz: None,
            unit_m: None,
            up: None,
            position_channels: None,
            asf: None,
            license: None,
            attribution: None,
            may_share: None,
            may_sell: None,
            no_derivatives: false,
        }
    }
}

impl InputRules {
    /// The rule of a folder of that name, and its place in the list.
    pub fn source_rule(&self, folder: &str) -> Option<(usize, &SourceRule)> {
        self.sources.iter().enumerate().find(|(_, rule)| matches(&rule.folder, folder))
    }

    /// The rule of an input folder by its path, with `/`: a rule's `folder` is its name, or the end of its path.
    pub fn rule_of_folder(&self, path: &str) -> Option<&SourceRule> {
        let fits = |rule: &&SourceRule| {
            let depth = rule.folder.matches('/').count() + 1;
            let parts: Vec<&str> = path.split('/').collect();
            matches(&rule.folder, &parts[parts.len().saturating_sub(depth)..].join("/"))
        };
        self.sources.iter().find(fits)
    }

    /// What holds for one clip: `[inputs]`, then its folder's rule, then the rules for its name.
    pub fn resolve(&self, rule: Option<&SourceRule>, source: &str, name: &str) -> SourceSettings {
        let inputs = &self.inputs;
        let mut settings = SourceSettings {
            rate_hz: inputs.rate_hz,
            unit_m: inputs.unit_m,
            up: inputs.up,
            position_channels: inputs.position_channels,
            ..SourceSettings::default()
        };
        if let Some(rule) = rule {
            lay(&mut settings.rate_hz, &rule.rate_hz);
            lay(&mut settings.unit_m, &rule.unit_m);
            lay(&mut settings.up, &rule.up);
            settings.position_channels = rule.position_channels.unwrap_or(settings.position_channels);
            lay(&mut settings.license, &rule.license);
            lay(&mut settings.attribution, &rule.attribution);
            lay(&mut settings.may_share, &rule.may_share);
            lay(&mut settings.may_sell, &rule.may_sell);
            settings.no_derivatives = rule.no_derivatives;
        }
        for rule in self.clips.iter().filter(|rule| rule.fits(source, name)) {
            lay(&mut settings.rate_hz, &rule.rate_hz);
            lay(&mut settings.unit_m, &rule.unit_m);
            lay(&mut settings.up, &rule.up);
            settings.position_channels = rule.position_channels.unwrap_or(settings.position_channels);
            lay(&mut settings.subject, &rule.subject);
            lay(&mut settings.license, &rule.license);
            lay(&mut settings.attribution, &rule.attribution);
            lay(&mut settings.may_share, &rule.may_share);
            lay(&mut settings.may_sell, &rule.may_sell);
            settings.no_derivatives = rule.no_derivatives.unwrap_or(settings.no_derivatives);
        }
        settings
    }

    /// Whether the user asked to leave a clip out.
    pub fn skips(&self, name: &str) -> bool {
        self.inputs.skip.iter().any(|pattern| fits_name(pattern, name))
    }
}

impl ClipRule {
    /// Whether it speaks of that clip.
    pub fn fits(&self, source: &str, name: &str) -> bool {
        self.source.as_deref().is_none_or(|wanted| wanted == source) && fits_name(&self.name, name)
    }
}

/// Whether a pattern fits a clip's name or its last component.
pub(crate) fn fits_name(pattern: &str, name: &str) -> bool {
    matches(pattern, name) || name.rsplit('/').next().is_some_and(|last| matches(pattern, last))
}

fn lay<T: Clone>(below: &mut Option<T>, over: &Option<T>) {
    if over.is_some() {
        below.clone_from(over);
    }
}
