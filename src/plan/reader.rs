//! Reads a tree of settings into a struct, and names every mistake in it, not only the first.
//!
//! Serde stops at the first error. Here an unknown field or a value of the wrong type is recorded and left out of
//! the next try, until the rest can be read. So any struct with `deny_unknown_fields` and `default` is checked
//! completely, with places, and needs no code of its own.

use super::document::{Entry, Node, Place, Value};
use serde::de::value::StrDeserializer;
use serde::de::{self, DeserializeOwned, DeserializeSeed, IntoDeserializer, Visitor};
use std::collections::BTreeSet;
use std::fmt;

/// A mistake, where, and at which path (`contacts.thesis.max_height_m`, `source[0].unit_m`).
#[derive(Clone, Debug)]
pub(crate) struct Mistake {
    /// Of the key where the key is wrong, of the value otherwise.
    pub(crate) place: Place,
    pub(crate) path: String,
    /// The value there.
    pub(crate) node: Node,
    pub(crate) kind: MistakeKind,
}

/// What is wrong.
#[derive(Clone, Debug)]
pub(crate) enum MistakeKind {
    /// No such field in its section; these are the ones that there are.
    UnknownField(&'static [&'static str]),
    /// A word that is none of these.
    UnknownWord(&'static [&'static str]),
    /// Another type than the one wanted, in serde's words.
    WrongType(String),
    /// A section without a field that it needs.
    Missing(&'static str),
    /// Anything else that a struct says of itself.
    Other(String),
}

/// Nobody mends more at a time, and each costs a try.
const MOST_MISTAKES: usize = 100;

/// Reads the tree as far as it can be read.
pub(crate) fn read<T: DeserializeOwned + Default>(root: &Node) -> (T, Vec<Mistake>) {
    let mut bad = BTreeSet::new();
    let mut mistakes = Vec::new();
    loop {
        let cursor = Cursor { node: root, path: String::new(), bad: &bad };
        let mistake = match T::deserialize(cursor.clone()) {
            Ok(value) => return (value, mistakes),
            Err(error) => *error.at(&cursor),
        };
        let path = mistake.path.clone();
        mistakes.push(mistake);
        // The root can't be left out, and a path that was left out can't come again.
        if path.is_empty() || !bad.insert(path) || mistakes.len() >= MOST_MISTAKES {
            return (T::default(), mistakes);
        }
    }
}

#[derive(Clone)]
struct Cursor<'a> {
    node: &'a Node,
    path: String,
    /// Paths to leave out.
    bad: &'a BTreeSet<String>,
}

/// Serde's error as facts; the place comes to it on its way out.
#[derive(Debug)]
enum Error {
    Bare(MistakeKind),
    Placed(Box<Mistake>),
}

impl Error {
    /// The innermost place wins.
    fn at(self, cursor: &Cursor<'_>) -> Box<Mistake> {
        self.at_place(cursor, &cursor.node.place)
    }

    fn at_place(self, cursor: &Cursor<'_>, place: &Place) -> Box<Mistake> {
        match self {
            Error::Placed(placed) => placed,
            Error::Bare(kind) => {
                let (path, node) = (cursor.path.clone(), cursor.node.clone());
                Box::new(Mistake { place: place.clone(), path, node, kind })
            }
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self:?}")
    }
}

impl std::error::Error for Error {}

impl de::Error for Error {
    fn custom<T: fmt::Display>(message: T) -> Error {
        Error::Bare(MistakeKind::Other(message.to_string()))
    }

    fn invalid_type(_: de::Unexpected<'_>, wanted: &dyn de::Expected) -> Error {
        Error::Bare(MistakeKind::WrongType(wanted.to_string()))
    }

    fn invalid_value(_: de::Unexpected<'_>, wanted: &dyn de::Expected) -> Error {
        Error::Bare(MistakeKind::WrongType(wanted.to_string()))
    }

    fn unknown_field(_: &str, valid: &'static [&'static str]) -> Error {
        Error::Bare(MistakeKind::UnknownField(valid))
    }

    fn unknown_variant(_: &str, valid: &'static [&'static str]) -> Error {
        Error::Bare(MistakeKind::UnknownWord(valid))
    }

    fn missing_field(field: &'static str) -> Error {
        Error::Bare(MistakeKind::Missing(field))
    }
}

impl<'a> Cursor<'a> {
    fn below(&self, node: &'a Node, path: String) -> Cursor<'a> {
        Cursor { node, path, bad: self.bad }
    }

    fn is_bad(&self) -> bool {
        self.bad.contains(&self.path)
    }
}

impl<'de> de::Deserializer<'de> for Cursor<'_> {
    type Error = Error;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        let read = match &self.node.value {
            Value::Text(text) => visitor.visit_str(text),
            Value::Date(text) => visitor.visit_str(text),
            Value::Boolean(flag) => visitor.visit_bool(*flag),
            Value::Float(number) => visitor.visit_f64(*number),
            Value::Integer(number) => match (i64::try_from(*number), u64::try_from(*number)) {
                (Ok(number), _) => visitor.visit_i64(number),
                (_, Ok(number)) => visitor.visit_u64(number),
                _ => visitor.visit_i128(*number),
            },
            Value::List(nodes) => visitor.visit_seq(List { cursor: self.clone(), nodes: nodes.iter().enumerate() }),
            Value::Table(entries) => {
                visitor.visit_map(Table { cursor: self.clone(), entries: entries.iter(), value: None })
            }
        };
        read.map_err(|error| Error::Placed(error.at(&self)))
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        valid: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        let read = match &self.node.value {
            Value::Text(word) => {
                let word: StrDeserializer<'_, Error> = word.as_str().into_deserializer();
                visitor.visit_enum(word)
            }
            _ => Err(Error::Bare(MistakeKind::WrongType(one_of(valid)))),
        };
        read.map_err(|error| Error::Placed(error.at(&self)))
    }

    /// A list is no section, though serde would take its elements for fields.
    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        match self.node.value {
            Value::Table(_) => self.deserialize_any(visitor),
            _ => Err(Error::Placed(Error::Bare(MistakeKind::WrongType(format!("struct {name}"))).at(&self))),
        }
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct
        seq tuple tuple_struct map identifier ignored_any
    }
}

struct List<'a> {
    cursor: Cursor<'a>,
    nodes: std::iter::Enumerate<std::slice::Iter<'a, Node>>,
}

impl<'de> de::SeqAccess<'de> for List<'_> {
    type Error = Error;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Error> {
        for (index, node) in self.nodes.by_ref() {
            let element = self.cursor.below(node, format!("{}[{index}]", self.cursor.path));
            if !element.is_bad() {
                return seed.deserialize(element).map(Some);
            }
        }
        Ok(None)
    }
}

struct Table<'a> {
    cursor: Cursor<'a>,
    entries: std::slice::Iter<'a, Entry>,
    value: Option<Cursor<'a>>,
}

impl<'de> de::MapAccess<'de> for Table<'_> {
    type Error = Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, Error> {
        for entry in self.entries.by_ref() {
            let path = match self.cursor.path.as_str() {
                "" => entry.key.clone(),
                path => format!("{path}.{}", entry.key),
            };
            let value = self.cursor.below(&entry.node, path);
            if value.is_bad() {
                continue;
            }
            let key: StrDeserializer<'_, Error> = entry.key.as_str().into_deserializer();
            let key = seed.deserialize(key).map_err(|error| Error::Placed(error.at_place(&value, &entry.key_place)))?;
            self.value = Some(value);
            return Ok(Some(key));
        }
        Ok(None)
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Error> {
        let cursor = self.value.take().expect("serde asks for a value after its key");
        seed.deserialize(cursor.clone()).map_err(|error| Error::Placed(error.at(&cursor)))
    }
}

fn one_of(valid: &[&str]) -> String {
    let words: Vec<String> = valid.iter().map(|word| format!("`{word}`")).collect();
    format!("one of {}", words.join(", "))
}
