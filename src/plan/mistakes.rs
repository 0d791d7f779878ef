//! Mistakes in words: what was found, why it can't be used, what to write.

use super::document::{Node, SourceKind, Value};
use super::error::PlanError;
use super::nearest::{list, nearest};
use super::reader::{Mistake, MistakeKind};
use super::stages::Stage;

/// Where a tree of settings stands, for messages.
pub(crate) enum Root<'a> {
    /// Sections of a config (or of a stage's options), with an example of every field.
    Config { reference: &'a Node },
    /// The `where` of a stage.
    Where { stage: Stage },
}

/// A value is quoted in a remedy if it is no longer than this, characters.
const MAX_QUOTED: usize = 60;

/// The mistake in words.
pub(crate) fn explain(mistake: &Mistake, root: &Root<'_>) -> PlanError {
    let Mistake { place, path, node, kind } = mistake;
    let words = match kind {
        MistakeKind::Missing(field) => Words { mistake, root, section: without_indices(path), field },
        _ => Words { mistake, root, section: section_of(path), field: field_of(path) },
    };
    let (what, why, try_) = match kind {
        MistakeKind::UnknownField(valid) => words.unknown_field(valid),
        MistakeKind::UnknownWord(valid) => (
            format!("{} is {node}", words.named()),
            match nearest(&text_of(node), valid) {
                Some(near) if valid.len() > 1 => format!("it can be {}; the nearest is `{near}`", list(valid)),
                _ => format!("it can be {}", list(valid)),
            },
            words.assign(words.field, &format!("{:?}", nearest(&text_of(node), valid).unwrap_or(valid[0]))),
        ),
        MistakeKind::WrongType(wanted) => (
            format!("{} is {}: {node}", words.named(), node.kind()),
            format!("{} is needed", needed(wanted, words.field, node)),
            words.example(words.field),
        ),
        MistakeKind::Missing(field) => {
            (format!("no `{field}` in {}", words.place_name()), "it has no default".to_owned(), words.example(field))
        }
        MistakeKind::Other(message) => {
            (format!("{} is {node}", words.named()), message.clone(), words.example(words.field))
        }
    };
    place.error(what, why, try_)
}

/// A value that has the right type and no meaning.
pub(crate) fn out_of_range(node: &Node, path: &str, why: String, reference: &Node) -> PlanError {
    let mistake =
        Mistake { place: node.place.clone(), path: path.to_owned(), node: node.clone(), kind: MistakeKind::Other(why) };
    explain(&mistake, &Root::Config { reference })
}

struct Words<'a> {
    mistake: &'a Mistake,
    root: &'a Root<'a>,
    /// Path of the section, `[i]` left out.
    section: String,
    field: &'a str,
}

impl Words<'_> {
    fn unknown_field(&self, valid: &[&str]) -> (String, String, String) {
        let Mistake { node, path, .. } = self.mistake;
        let is_section = matches!(node.value, Value::Table(_)) || is_list_of_tables(node);
        let kind = self.mistake.place.source.kind;
        let what = match self.root {
            Root::Where { stage } => {
                format!("unknown condition `{}` in `where` of stage `{}`", self.field, stage.name())
            }
            _ if kind == SourceKind::Pipeline => format!("unknown option `{}` of {}", self.field, self.place_name()),
            _ if is_section && !path.contains('.') => format!("unknown section [{path}]"),
            _ if self.section.is_empty() => format!("unknown field `{}` outside any section", self.field),
            _ => format!("unknown field `{}` in {}", self.field, self.place_name()),
        };
        let no_such = match self.root {
            Root::Where { .. } => "no such condition",
            _ if kind == SourceKind::Pipeline => "no such option",
            _ if is_section => "no such section",
            _ => "no such field",
        };
        if let Some(near) = nearest(self.field, valid) {
            let remedy = match is_section {
                true => self.example(near),
                // With another unit in its name the value means something else.
                false if unit_of(self.field) != unit_of(near) => self.example(near),
                false => self.assign(near, &self.quoted()),
            };
            return (what, format!("{no_such}; the nearest is `{near}`"), remedy);
        }
        let homes = self.homes();
        if let Some(home) = homes.first() {
            let remedy = match kind {
                SourceKind::Set => format!("--set {home}.{}={}", self.field, node.place.raw()),
                _ => format!("{} below [{home}]", self.assign(self.field, &self.quoted())),
            };
            let named: Vec<String> = homes.iter().map(|home| format!("[{home}]")).collect();
            return (what, format!("no such field here; it belongs to {}", named.join(" or ")), remedy);
        }
        let there = match valid {
            [] => format!("{no_such}; there are none"),
            _ => format!("{no_such}; there are {}", list(valid).replace(" or ", " and ")),
        };
        let where_to_look = match kind {
            SourceKind::Truth => "configs/truth/bandai-namco.toml is an example",
            _ => "configs/default.toml lists every setting",
        };
        (what, there, format!("take it out; {where_to_look}"))
    }

    /// The other sections that have a field of this name, if they are few enough to be meant.
    fn homes(&self) -> Vec<String> {
        const FEW: usize = 2;
        let Root::Config { reference } = self.root else { return Vec::new() };
        let mut homes = Vec::new();
        sections_with(reference, self.field, "", &mut homes);
        homes.retain(|home| !home.is_empty());
        if homes.len() > FEW { Vec::new() } else { homes }
    }

    fn named(&self) -> String {
        match self.root {
            Root::Where { .. } => format!("`{}` in {}", self.field, self.place_name()),
            _ if self.section.is_empty() => format!("`{}`", self.field),
            _ => format!("`{}` in {}", self.field, self.place_name()),
        }
    }

    fn place_name(&self) -> String {
        if let Root::Where { stage } = self.root {
            return format!("`where` of stage `{}`", stage.name());
        }
        let section = self.section.as_str();
        if self.mistake.place.source.kind == SourceKind::Pipeline {
            let top = section.split('.').next().unwrap_or(section);
            let stage = Stage::ALL.into_iter().find(|stage| stage.section() == Some(top));
            return format!("stage `{}`", stage.map_or(section, |stage| stage.name()));
        }
        match section {
            "" => "the top level".to_owned(),
            "source" | "clip" | "rule" => format!("[[{section}]]"),
            _ => format!("[{section}]"),
        }
    }

    /// `field = value`, or the whole `--set`.
    fn assign(&self, field: &str, value: &str) -> String {
        match self.mistake.place.source.kind {
            // A word needs no quotes there, and a shell would take them away.
            SourceKind::Set => format!("--set {}={}", join(&self.section, field), value.trim_matches('"')),
            _ => format!("{field} = {value}"),
        }
    }

    /// An assignment of the default, or of an example where the setting is off by default; the head of a section.
    fn example(&self, field: &str) -> String {
        let reference = match self.root {
            Root::Config { reference } => reference,
            Root::Where { .. } => return self.assign(field, example_condition(field)),
        };
        let path = join(&self.section, field);
        let listed = format!("{}[0].{field}", self.section);
        let Some(node) = reference.find(&path).or_else(|| reference.find(&listed)) else {
            return "see configs/default.toml".to_owned();
        };
        let is_set = self.mistake.place.source.kind == SourceKind::Set;
        match &node.value {
            Value::Table(entries) if is_set => match entries.first() {
                Some(first) => format!("--set {path}.{}={}", first.key, first.node.place.raw()),
                None => format!("put [{path}] into a config"),
            },
            Value::Table(_) => format!("[{path}]"),
            Value::List(_) if is_list_of_tables(node) && is_set => format!("put [[{path}]] into a config"),
            Value::List(_) if is_list_of_tables(node) => format!("[[{path}]]"),
            _ => self.assign(field, node.place.raw()),
        }
    }

    /// The user's value if it is short, to be written again.
    fn quoted(&self) -> String {
        let raw = match self.mistake.place.source.kind {
            SourceKind::Set => self.mistake.place.source.text.as_str(),
            _ => self.mistake.node.place.raw(),
        };
        match raw.contains('\n') || raw.chars().count() > MAX_QUOTED {
            true => "...".to_owned(),
            false => raw.to_owned(),
        }
    }
}

/// A value for a condition of a `where`.
fn example_condition(field: &str) -> &'static str {
    match field {
        "gait" => "\"walk\"",
        "format" => "\"bvh\"",
        "min_gait_confidence" => "0.8",
        _ if unit_of(field).is_some() => "1.0",
        _ => "\"cmu\"",
    }
}

fn is_list_of_tables(node: &Node) -> bool {
    let elements = node.elements();
    !elements.is_empty() && elements.iter().all(|element| matches!(element.value, Value::Table(_)))
}

fn sections_with(node: &Node, field: &str, path: &str, homes: &mut Vec<String>) {
    for entry in node.entries() {
        if entry.key == field && !matches!(entry.node.value, Value::Table(_)) {
            homes.push(path.to_owned());
        }
        sections_with(&entry.node, field, &join(path, &entry.key), homes);
    }
}

fn join(section: &str, field: &str) -> String {
    match section {
        "" => field.to_owned(),
        _ => format!("{section}.{field}"),
    }
}

fn section_of(path: &str) -> String {
    let section = path.rsplit_once('.').map_or("", |(section, _)| section);
    without_indices(section)
}

fn without_indices(path: &str) -> String {
    path.split('.').map(|part| part.split('[').next().unwrap_or(part)).collect::<Vec<_>>().join(".")
}

fn field_of(path: &str) -> &str {
    let field = path.rsplit('.').next().unwrap_or(path);
    field.split('[').next().unwrap_or(field)
}

fn text_of(node: &Node) -> String {
    match &node.value {
        Value::Text(text) => text.clone(),
        _ => node.to_string(),
    }
}

/// The unit in a field's name.
fn unit_of(field: &str) -> Option<&'static str> {
    let (_, suffix) = field.rsplit_once('_')?;
    Some(match suffix {
        "m" => "metres",
        "m2" => "square metres",
        "mps" => "metres a second",
        "mps2" => "metres a second squared",
        "s" => "seconds",
        "s2" => "square seconds",
        "hz" => "times a second",
        "rad" => "radians",
        "bytes" => "bytes",
        "cycles" => "cycles",
        _ => return None,
    })
}

fn needed(wanted: &str, field: &str, node: &Node) -> String {
    let words = in_words(wanted);
    match (&node.value, unit_of(field)) {
        (Value::Integer(number), _) if *number > 0 && words.starts_with("a whole number") => {
            "a smaller whole number".to_owned()
        }
        (_, Some(unit)) if words.contains("number") => format!("{words} in {unit}"),
        _ => words,
    }
}

/// Serde's word for a type as a user would say it.
fn in_words(wanted: &str) -> String {
    match wanted {
        "f64" | "f32" => "a number".to_owned(),
        "u8" | "u16" | "u32" | "u64" | "usize" => "a whole number, not below 0,".to_owned(),
        "i8" | "i16" | "i32" | "i64" => "a whole number".to_owned(),
        "a boolean" => "`true` or `false`".to_owned(),
        "a string" => "text in quotes".to_owned(),
        "a sequence" => "a list in [ ]".to_owned(),
        _ if wanted.starts_with("struct ") => "a section with fields".to_owned(),
        other => other.to_owned(),
    }
}
