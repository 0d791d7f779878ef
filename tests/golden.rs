//! Lines of the small files in `tests/golden` that the reference programs wrote.

use motionmill::annotate::Gait;
use motionmill::annotate::gait_tokens::Token;
use serde_json::Value;
use std::path::Path;

/// The JSON lines of a golden file.
pub(crate) fn lines(name: &str) -> Vec<Value> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(name);
    parse(&std::fs::read_to_string(path).unwrap())
}

/// JSON, line by line.
pub(crate) fn parse(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// Tokens written as `[["L", 12], ...]`.
pub(crate) fn tokens(line: &Value) -> Vec<Token> {
    runs(&line["tokens"])
        .into_iter()
        .flat_map(|(letter, n_frames)| vec![Token::from_letter(letter.chars().next().unwrap()).unwrap(); n_frames])
        .collect()
}

/// Gaits written as `[["walk", 0, 85], ...]`.
pub(crate) fn gaits(line: &Value) -> Vec<Gait> {
    let segments = line["segments"].as_array().unwrap();
    segments
        .iter()
        .flat_map(|segment| {
            let n_frames = segment[2].as_u64().unwrap() - segment[1].as_u64().unwrap();
            vec![gait(segment[0].as_str().unwrap()); n_frames as usize]
        })
        .collect()
}

/// A class by its name.
pub(crate) fn gait(name: &str) -> Gait {
    let all = [Gait::Unknown, Gait::Stand, Gait::Walk, Gait::Run, Gait::Jump, Gait::Other];
    all.into_iter().find(|gait| gait.name() == name).unwrap()
}

fn runs(value: &Value) -> Vec<(&str, usize)> {
    let pairs = value.as_array().unwrap().iter();
    pairs.map(|pair| (pair[0].as_str().unwrap(), pair[1].as_u64().unwrap() as usize)).collect()
}
