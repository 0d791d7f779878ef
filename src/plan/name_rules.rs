//! Files of rules that say a clip's class by its name: what `evaluate --names` compares with.

use super::document::{Node, Source, Value, parse};
use super::error::PlanError;
use super::mistakes::{Root, explain};
use super::reader::read;
use super::shipped;
use crate::annotate::Gait;
use crate::evaluate::{NameRule, NameRules};
use regex::Regex;
use serde::Deserialize;
use std::sync::Arc;

#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct RuleFile {
    rule: Vec<Rule>,
}

/// Both are needed. Were they so to serde, a wrong value would be missing as well.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Rule {
    name: Option<String>,
    gait: Option<Gait>,
}

/// Reads rules: those that ship with the program, by their bare name, or a file.
///
/// # Errors
/// Every mistake in it, in the order of the text: no TOML, unknown fields and words, missing fields, a `name` that is no regular
/// expression; a file without rules.
pub fn load_name_rules(name: &str) -> Result<NameRules, Vec<PlanError>> {
    read_rules(&shipped::truth(name).map_err(|error| vec![error])?)
}

fn read_rules(source: &Arc<Source>) -> Result<NameRules, Vec<PlanError>> {
    let root = parse(source)?;
    let reference = parse(&shipped::truth_reference())?;
    let (file, mistakes) = read::<RuleFile>(&root);
    let explained = mistakes.iter().map(|mistake| explain(mistake, &Root::Config { reference: &reference }));
    let mut errors: Vec<PlanError> = explained.collect();
    let rules = root.get("rule").map_or(&[][..], Node::elements);
    errors.extend(rules.iter().flat_map(missing).chain(rules.iter().filter_map(wrong_pattern)));
    if !errors.is_empty() {
        errors.sort_by_key(|error| (error.line, error.column));
        return Err(errors);
    }
    let rules = file.rule.into_iter().filter_map(|rule| {
        // Rules in which a field is missing, or is no regular expression, were refused above.
        Some(NameRule { name: Regex::new(&rule.name?).ok()?, gait: rule.gait? })
    });
    let rules = NameRules { rules: rules.collect() };
    match rules.rules.is_empty() {
        false => Ok(rules),
        true => Err(vec![source.end().error(
            "no rule in it".to_owned(),
            "rules say which class the names of clips promise".to_owned(),
            "[[rule]] name = \"_walk_\" gait = \"walk\", on three lines".to_owned(),
        )]),
    }
}

fn missing(rule: &Node) -> Vec<PlanError> {
    let fields = [("name", "name = \"_walk_\""), ("gait", "gait = \"walk\"")];
    // What is no section is a mistake already.
    let is_section = matches!(rule.value, Value::Table(_));
    let missing = fields.into_iter().filter(|(field, _)| is_section && rule.get(field).is_none());
    let error = |(field, example): (&str, &str)| {
        let why = "a rule says which names it is about, and which class they promise".to_owned();
        rule.place.error(format!("no `{field}` in [[rule]]"), why, example.to_owned())
    };
    missing.map(error).collect()
}

fn wrong_pattern(rule: &Node) -> Option<PlanError> {
    let name = rule.get("name")?;
    let Value::Text(text) = &name.value else { return None };
    let error = Regex::new(text).err()?.to_string();
    // The last line says what; those before draw where.
    let what = error.lines().last().unwrap_or_default().trim_start_matches("error: ");
    Some(name.place.error(
        format!("`name` in [[rule]] is {name}: {what}"),
        "it is read as a regular expression".to_owned(),
        format!("name = {:?} for these very characters", regex::escape(text)),
    ))
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use crate::plan::document::SourceKind;
    use proptest::prelude::*;

    fn says(text: &str) -> String {
        match read_rules(&Source::new("mine.toml", text, SourceKind::Truth)) {
            Ok(rules) => format!("{} rules", rules.rules.len()),
            Err(errors) => errors.iter().map(|error| format!("{error}\n")).collect(),
        }
    }

    #[test]
    fn the_names_of_bandai_namco_promise_their_gaits() {
        let rules = load_name_rules("bandai-namco").unwrap();
        for (name, gait) in [
            ("bandai-namco/dataset-1/dataset-1_walk_active_001", Some(Gait::Walk)),
            ("x/dataset-1_walk-turn-left_elderly_003", Some(Gait::Walk)),
            ("x/dataset-1_run_active_001", Some(Gait::Run)),
            ("x/dataset-1_dash_chimpira_001", Some(Gait::Run)),
            ("x/dataset-2_run_elderly_001", Some(Gait::Walk)),
            ("x/dataset-2_wave-both-hands_normal_010", Some(Gait::Stand)),
            ("x/dataset-2_raise-up-left-hand_masculine_045", Some(Gait::Stand)),
            ("x/dataset-1_bow_active_001", None),
            ("x/dataset-1_punch_active_001", None),
            ("dataset-2_walk_x/dataset-1_kick_active_001", None),
            ("cmu/02/02_01", None),
        ] {
            assert_eq!(rules.class_of(name), gait, "{name}");
        }
    }

    #[test]
    fn mistakes_say_where_and_what_to_write() {
        assert_eq!(says("[[rule]]\nname = \"a\"\ngait = \"other\"\n"), "1 rules");
        for (text, wanted) in [
            (
                "[[rule]]\nname = \"a\"\ngait = \"wlak\"\n",
                "error: mine.toml:3:8: `gait` in [[rule]] is \"wlak\"\n  why: it can be `unknown`, `stand`, `walk`, `run`, `jump` or `other`; the nearest is `walk`\n  try: gait = \"walk\"\n",
            ),
            (
                "[[rule]]\nname = \"a(\"\ngait = \"walk\"\n",
                "error: mine.toml:2:8: `name` in [[rule]] is \"a(\": unclosed group\n  why: it is read as a regular expression\n  try: name = \"a\\\\(\" for these very characters\n",
            ),
            (
                "[[rule]]\nnmae = \"a\"\ngait = \"walk\"\n",
                "error: mine.toml:1:1: no `name` in [[rule]]\n  why: a rule says which names it is about, and which class they promise\n  try: name = \"_walk_\"\nerror: mine.toml:2:1: unknown field `nmae` in [[rule]]\n  why: no such field; the nearest is `name`\n  try: name = \"a\"\n",
            ),
            (
                "[[rule]]\nname = 3\ngait = \"walk\"\n",
                "error: mine.toml:2:8: `name` in [[rule]] is a whole number: 3\n  why: text in quotes is needed\n  try: name = \"dataset-[0-9]+_run_elderly_[^/]*$\"\n",
            ),
            (
                "max_height_m = 1\n[[rule]]\nname = \"a\"\ngait = \"walk\"\n",
                "error: mine.toml:1:1: unknown field `max_height_m` outside any section\n  why: no such field; there are `rule`\n  try: take it out; configs/truth/bandai-namco.toml is an example\n",
            ),
            (
                "",
                "error: mine.toml:1:1: no rule in it\n  why: rules say which class the names of clips promise\n  try: [[rule]] name = \"_walk_\" gait = \"walk\", on three lines\n",
            ),
        ] {
            assert_eq!(says(text), wanted, "{text}");
        }
        assert!(says("[[rule]\n").starts_with("error: mine.toml:1:"), "{}", says("[[rule]\n"));
        let absent = load_name_rules("bandai").unwrap_err();
        assert_eq!(
            absent[0].to_string(),
            "error: bandai: no such file of rules\n  why: it is neither a file nor one of `bandai-namco`\n  try: the nearest file of rules that ships is `bandai-namco`"
        );
    }

    proptest! {
        #[test]
        fn any_text_gives_rules_or_places(text in "(\\[\\[rule\\]\\]|name|gait|=|\"walk\"|\"[a(\\[*]{0,3}\"|\n|[a-z{},.]| ){0,30}") {
            let said = says(&text);
            prop_assert!(said.ends_with(" rules") || said.starts_with("error: mine.toml:"), "{}", said);
        }
    }
}
