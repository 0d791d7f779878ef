//! The user's TOML as a tree that remembers where every key and value stands, and layers of such trees.

use super::error::PlanError;
use std::fmt;
use std::ops::Range;
use std::sync::Arc;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A text that settings come from.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Source {
    /// A file's name as the user gave it; a whole `--set a.b=c`.
    pub(crate) name: String,
    /// Its text.
    pub(crate) text: String,
    /// What it is.
    pub(crate) kind: SourceKind,
}

/// What kind of text settings come from: messages differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SourceKind {
    Pipeline,
    Config,
    Set,
    /// Rules about names.
    Truth,
}

/// Where something stands in a source.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    pub(crate) source: Arc<Source>,
    span: Range<usize>,
}

/// A value and its place.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub(crate) value: Value,
    pub(crate) place: Place,
}

/// What TOML can say. Tables keep the order of their keys' names.
#[derive(Clone, Debug)]
pub(crate) enum Value {
    Text(String),
    Integer(i128),
    Float(f64),
    Boolean(bool),
    Date(String),
    List(Vec<Node>),
    Table(Vec<Entry>),
}

/// A key, its place, and what it holds.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub(crate) key: String,
    pub(crate) key_place: Place,
    pub(crate) node: Node,
}

impl Source {
    pub(crate) fn new(name: &str, text: &str, kind: SourceKind) -> Arc<Source> {
        Arc::new(Source { name: name.to_owned(), text: text.to_owned(), kind })
    }

    /// The source as a whole.
    pub(crate) fn start(self: &Arc<Source>) -> Place {
        Place { source: Arc::clone(self), span: 0..0 }
    }

    /// Behind its last character.
    pub(crate) fn end(self: &Arc<Source>) -> Place {
        self.place(self.text.len()..self.text.len())
    }

    fn place(self: &Arc<Source>, span: Range<usize>) -> Place {
        Place { source: Arc::clone(self), span }
    }
}

impl Place {
    /// A mistake at this place.
    pub(crate) fn error(&self, what: String, why: String, try_: String) -> PlanError {
        let (line, column) = match self.source.kind {
            SourceKind::Set => (None, None),
            _ => (Some(self.line()), Some(self.column())),
        };
        PlanError { file: self.source.name.clone(), line, column, what, why, try_ }
    }

    /// The text there, as the user wrote it.
    pub(crate) fn raw(&self) -> &str {
        self.source.text.get(self.span.clone()).unwrap_or("")
    }

    /// The whole line that it begins on, trimmed.
    pub(crate) fn line_text(&self) -> &str {
        let end =
            self.source.text[self.line_start()..].find('\n').map_or(self.source.text.len(), |n| self.line_start() + n);
        self.source.text[self.line_start()..end].trim()
    }

    /// Orders places of one source.
    pub(crate) fn at(&self) -> usize {
        self.span.start
    }

    fn line(&self) -> u32 {
        1 + self.before().matches('\n').count() as u32
    }

    fn column(&self) -> u32 {
        1 + self.before()[self.line_start()..].chars().count() as u32
    }

    fn line_start(&self) -> usize {
        self.before().rfind('\n').map_or(0, |n| n + 1)
    }

    fn before(&self) -> &str {
        let text = &self.source.text;
        let mut at = self.span.start.min(text.len());
        while !text.is_char_boundary(at) {
            at -= 1;
        }
        &text[..at]
    }
}

/// Reads a source as TOML.
///
/// # Errors
/// Every place where it is not TOML; of several on one line, the first.
pub(crate) fn parse(source: &Arc<Source>) -> Result<Node, Vec<PlanError>> {
    if let Some(at) = too_deep(&source.text) {
        return Err(vec![too_deep_error(&source.place(at..at))]);
    }
    let (table, syntax) = DeTable::parse_recoverable(&source.text);
    let mut errors = Vec::new();
    let root = Node { value: own_table(source, table.get_ref(), &mut errors), place: source.start() };
    let mut faults: Vec<(Place, String)> =
        syntax.iter().map(|error| (source.place(error.span().unwrap_or(0..0)), error.message().to_owned())).collect();
    faults.sort_by_key(|(place, _)| place.at());
    faults.dedup_by_key(|(place, _)| place.line());
    errors.extend(faults.iter().map(|(place, message)| syntax_error(place, message)));
    if errors.is_empty() { Ok(root) } else { Err(errors) }
}

/// Reads the argument of `--set`, such as `contacts.thesis.max_height_m=0.04`, as a tree of one value. A bare word
/// is text: `contacts.detector=thesis`.
///
/// # Errors
/// No `=`, an empty name in the path, or a value that is not TOML.
pub(crate) fn parse_set(argument: &str) -> Result<Node, PlanError> {
    let name = format!("--set {argument}");
    let Some((path, text)) = argument.split_once('=') else {
        let whole = Source::new(&name, "", SourceKind::Set).start();
        return Err(whole.error(
            format!("no `=` in `{argument}`"),
            "a value is set by its path in the config, `=`, and the value".to_owned(),
            "--set contacts.detector=thesis".to_owned(),
        ));
    };
    let source = Source::new(&name, text.trim(), SourceKind::Set);
    let keys: Vec<&str> = path.split('.').map(str::trim).collect();
    if keys.iter().any(|key| key.is_empty()) {
        return Err(source.start().error(
            format!("`{path}` is no path to a value"),
            "sections and fields are separated by single dots".to_owned(),
            "--set contacts.thesis.max_height_m=0.05".to_owned(),
        ));
    }
    let whole = source.place(0..source.text.len());
    if keys.len() > MAX_DEPTH || too_deep(&source.text).is_some() {
        return Err(too_deep_error(&whole));
    }
    let mut errors = Vec::new();
    let value = match DeValue::parse(&source.text) {
        Ok(value) => own_value(&source, &value, &mut errors),
        Err(_) if is_word(&source.text) => Value::Text(source.text.clone()),
        Err(error) => return Err(syntax_error(&whole, error.message())),
    };
    if let Some(error) = errors.pop() {
        return Err(error);
    }
    Ok(nest(&keys, Node { value, place: whole }))
}

/// The node as the only value at a path of keys.
pub(crate) fn nest(keys: &[&str], leaf: Node) -> Node {
    keys.iter().rev().fold(leaf, |node, &key| {
        let place = node.place.clone();
        let entry = Entry { key: key.to_owned(), key_place: place.clone(), node };
        Node { value: Value::Table(vec![entry]), place }
    })
}

impl Node {
    /// An empty table.
    pub(crate) fn empty(source: &Arc<Source>) -> Node {
        Node { value: Value::Table(Vec::new()), place: source.start() }
    }

    /// Lays another tree over this one: tables are merged, everything else is replaced.
    pub(crate) fn overlay(&mut self, over: Node) {
        match (&mut self.value, over.value) {
            (Value::Table(entries), Value::Table(others)) => {
                for other in others {
                    match entries.iter_mut().find(|entry| entry.key == other.key) {
                        Some(entry) => {
                            entry.key_place = other.key_place;
                            entry.node.overlay(other.node);
                        }
                        None => entries.push(other),
                    }
                }
            }
            (value, other) => {
                *value = other;
                self.place = over.place;
            }
        }
    }

    /// The entries of a table; none of anything else.
    pub(crate) fn entries(&self) -> &[Entry] {
        match &self.value {
            Value::Table(entries) => entries,
            _ => &[],
        }
    }

    /// The elements of a list; none of anything else.
    pub(crate) fn elements(&self) -> &[Node] {
        match &self.value {
            Value::List(nodes) => nodes,
            _ => &[],
        }
    }

    /// What a key of a table holds.
    pub(crate) fn get(&self, key: &str) -> Option<&Node> {
        self.entries().iter().find(|entry| entry.key == key).map(|entry| &entry.node)
    }

    /// What stands at a path such as `graph.thresholds_m2[0]`.
    pub(crate) fn find(&self, path: &str) -> Option<&Node> {
        path.split('.').try_fold(self, |node, part| {
            let (key, index) = match part.split_once('[') {
                Some((key, index)) => (key, index.trim_end_matches(']').parse::<usize>().ok()),
                None => (part, None),
            };
            let node = node.get(key)?;
            match index {
                Some(index) => node.elements().get(index),
                None => Some(node),
            }
        })
    }

    /// Whether it is text, a number ...: the word in messages.
    pub(crate) fn kind(&self) -> &'static str {
        match self.value {
            Value::Text(_) => "text",
            Value::Integer(_) => "a whole number",
            Value::Float(_) => "a number with a fraction",
            Value::Boolean(_) => "true or false",
            Value::Date(_) => "a date",
            Value::List(_) => "a list",
            Value::Table(_) => "a section",
        }
    }
}

impl fmt::Display for Node {
    /// On one line and short, for messages.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.value {
            Value::Text(text) => write!(f, "{text:?}"),
            Value::Integer(number) => write!(f, "{number}"),
            Value::Float(number) => write!(f, "{number:?}"),
            Value::Boolean(flag) => write!(f, "{flag}"),
            Value::Date(date) => write!(f, "{date}"),
            Value::List(nodes) if nodes.len() > 4 => write!(f, "[... {} values]", nodes.len()),
            Value::List(nodes) => {
                let words: Vec<String> = nodes.iter().map(Node::to_string).collect();
                write!(f, "[{}]", words.join(", "))
            }
            Value::Table(_) => write!(f, "{{ ... }}"),
        }
    }
}

fn own_table(source: &Arc<Source>, table: &DeTable<'_>, errors: &mut Vec<PlanError>) -> Value {
    let entries = table.iter().map(|(key, value)| Entry {
        key: key.get_ref().to_string(),
        key_place: source.place(key.span()),
        node: Node { value: own_value(source, value, errors), place: source.place(value.span()) },
    });
    Value::Table(entries.collect())
}

fn own_value(source: &Arc<Source>, value: &Spanned<DeValue<'_>>, errors: &mut Vec<PlanError>) -> Value {
    match value.get_ref() {
        DeValue::String(text) => Value::Text(text.to_string()),
        DeValue::Boolean(flag) => Value::Boolean(*flag),
        DeValue::Datetime(date) => Value::Date(date.to_string()),
        DeValue::Table(table) => own_table(source, table, errors),
        DeValue::Array(array) => {
            let nodes = array
                .iter()
                .map(|element| Node { value: own_value(source, element, errors), place: source.place(element.span()) });
            Value::List(nodes.collect())
        }
        DeValue::Integer(number) => match i128::from_str_radix(number.as_str(), number.radix()) {
            Ok(number) => Value::Integer(number),
            Err(_) => too_large(source, value.span(), errors),
        },
        DeValue::Float(number) => match number.as_str().parse::<f64>() {
            Ok(number) => Value::Float(number),
            Err(_) => too_large(source, value.span(), errors),
        },
    }
}

/// Sections and lists within each other: trees are walked by recursion, and no setting lies deeper than four.
const MAX_DEPTH: usize = 64;

/// Where a text goes deeper than [`MAX_DEPTH`], by brackets or by a dotted key. Text in quotes and comments don't count.
fn too_deep(text: &str) -> Option<usize> {
    let (mut brackets, mut dots) = (0usize, 0usize);
    let mut characters = text.char_indices();
    while let Some((at, character)) = characters.next() {
        match character {
            '"' | '\'' => {
                while let Some((_, inside)) = characters.next() {
                    if inside == character {
                        break;
                    }
                    if inside == '\\' && character == '"' {
                        characters.next();
                    }
                }
            }
            '#' => {
                characters.by_ref().find(|&(_, inside)| inside == '\n');
                dots = 0;
            }
            '[' | '{' => (brackets, dots) = (brackets + 1, 0),
            ']' | '}' => (brackets, dots) = (brackets.saturating_sub(1), 0),
            '=' | ',' | '\n' => dots = 0,
            '.' => dots += 1,
            _ => {}
        }
        if brackets > MAX_DEPTH || dots > MAX_DEPTH {
            return Some(at);
        }
    }
    None
}

fn too_deep_error(place: &Place) -> PlanError {
    place.error(
        format!("more than {MAX_DEPTH} sections or lists within each other"),
        "no setting lies that deep".to_owned(),
        "see configs/default.toml for every setting".to_owned(),
    )
}

fn too_large(source: &Arc<Source>, span: Range<usize>, errors: &mut Vec<PlanError>) -> Value {
    let place = source.place(span);
    errors.push(place.error(
        format!("`{}` is too large a number", place.raw()),
        "no field takes a number of that size".to_owned(),
        "write a smaller one".to_owned(),
    ));
    Value::Integer(0)
}

fn syntax_error(place: &Place, message: &str) -> PlanError {
    let line = place.line_text();
    let remedy = match line.split_once('=') {
        _ if message == "duplicate key" => "keep one of the two".to_owned(),
        Some((key, word)) if is_word(without_comment(word)) => {
            format!("{} = \"{}\"", key.trim(), without_comment(word))
        }
        _ if place.source.kind == SourceKind::Set => "put text in quotes, lists in [ ]".to_owned(),
        _ => format!("mend this line: {line}"),
    };
    let why = match message {
        "duplicate key" => "a name may stand once in a section, or it would be unclear which value counts",
        _ => "settings are TOML: `name = value`, text in quotes, sections in [ ]",
    };
    place.error(format!("not TOML: {message}"), why.to_owned(), remedy)
}

fn without_comment(value: &str) -> &str {
    value.split('#').next().unwrap_or(value).trim()
}

/// A word that somebody forgot to quote, rather than a broken number, list or date.
fn is_word(text: &str) -> bool {
    text.starts_with(|c: char| c.is_alphabetic())
        && text.chars().all(|c| c.is_alphanumeric() || matches!(c, '-' | '_' | '/' | ' '))
}
