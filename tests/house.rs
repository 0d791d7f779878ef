//! The house keeps its order: which room may know of which, who names timely, arrow or clap, what pure rooms leave
//! alone (DESIGN 2). Reads the sources as text, so that an arrow the wrong way fails here and not in a review.

use regex::Regex;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

/// What everything outside the pure rooms may name.
const PURE: [&str; 8] = ["motion", "formats", "annotate", "procedural", "cluster", "synthesis", "evaluate", "picture"];

/// A room's rooms: those it may name beside itself, and all pure rooms if it is told so.
struct Room {
    name: &'static str,
    all_pure: bool,
    may_name: &'static [&'static str],
}

const fn pure(name: &'static str, may_name: &'static [&'static str]) -> Room {
    Room { name, all_pure: false, may_name }
}

const fn worldly(name: &'static str, may_name: &'static [&'static str]) -> Room {
    Room { name, all_pure: true, may_name }
}

const ROOMS: [Room; 13] = [
    pure("motion", &[]),
    pure("formats", &["motion"]),
    pure("annotate", &["motion"]),
    // Its ground truth speaks of feet and gaits.
    pure("procedural", &["motion", "annotate"]),
    pure("cluster", &["motion", "formats", "procedural", "annotate"]),
    pure("synthesis", &["motion", "formats", "procedural", "annotate", "cluster"]),
    pure("evaluate", &["motion", "formats", "procedural", "annotate", "cluster", "synthesis"]),
    pure("picture", &["motion", "formats", "procedural", "annotate", "cluster", "synthesis"]),
    worldly("corpus", &[]),
    worldly("inputs", &[]),
    // A config holds the settings of inputs.
    worldly("plan", &["inputs"]),
    worldly("flow", &["corpus", "inputs", "plan"]),
    worldly("cli", &["corpus", "inputs", "plan", "flow"]),
];

impl Room {
    fn may_name(&self, other: &str) -> bool {
        other == self.name
            || self.may_name.contains(&other)
            || self.all_pure && PURE.contains(&other)
            || ROOMS.iter().all(|room| room.name != other)
    }
}

/// A crate and the only room that names it.
const KEPT: [(&str, &str); 7] = [
    ("timely", "flow"),
    ("differential_dataflow", "flow"),
    ("arrow", "corpus"),
    ("parquet", "corpus"),
    ("clap", "cli"),
    ("indicatif", "cli"),
    ("plotters", "picture"),
];

const MOST_LINES: usize = 600;
const NO_NAMES: [&str; 4] = ["util.rs", "utils.rs", "helpers.rs", "common.rs"];

static TEST_MODULE: LazyLock<Regex> = LazyLock::new(|| Regex::new(r"^(pub(\(\w+\))? )?mod \w+ \{").unwrap());

static ROOT_PATH: LazyLock<Regex> =
    LazyLock::new(|| Regex::new(r"\b(crate|super(?:\s*::\s*super)*)\s*::\s*(\w+|\{)").unwrap());

/// One of the crates that are kept, as the first word of a path or used whole.
static CRATE: LazyLock<Regex> = LazyLock::new(|| {
    let names = KEPT.map(|(name, _)| name).join("|");
    Regex::new(&format!(r"(?:^|[^:\w]|[^\w]::)({names})\s*(?:::|;|\bas\b)")).unwrap()
});

/// Files, clocks, sockets, processes, threads, the environment, printing, and functions whose bits depend on the platform.
static IMPURE: LazyLock<Regex> = LazyLock::new(|| {
    let world = "(fs|time|net|env|process|thread)";
    let platform = "sin|cos|tan|sin_cos|asin|acos|atan|atan2|sinh|cosh|tanh|exp|exp2|exp_m1|ln|ln_1p|log|log2|log10|powf|cbrt|hypot";
    let things = [
        format!(r"std\s*::\s*{world}\b|std\s*::\s*\{{[^}}]*\b{world}\b|std\s*::\s*io\s*::\s*(stdin|stdout|stderr)\b"),
        r"\be?print(ln)?!|\bdbg!".to_owned(),
        format!(r"\.({platform})\("),
    ];
    Regex::new(&things.join("|")).unwrap()
});

static MACHINE_PATH: LazyLock<Regex> = LazyLock::new(|| {
    let roots = ["work", "root", "home", "tmp"].join("|");
    Regex::new(&format!(r#"(^|[\s"'`(=:\[<,])/({roots})(/|$|[\s"'`),;])"#)).unwrap()
});

/// What is wrong with a file of `src`; `path` is relative to it, with slashes.
fn flaws(path: &str, text: &str) -> Vec<String> {
    let mut flaws = Vec::new();
    let name = path.rsplit('/').next().unwrap_or(path);
    if NO_NAMES.contains(&name) {
        flaws.push(format!("{path}: a name that says nothing; put it beside its caller or call it by its deed"));
    }
    let lines = text.lines().count();
    if lines > MOST_LINES {
        flaws.push(format!("{path}: {lines} lines, more than {MOST_LINES}: there are two ideas in it"));
    }
    let Some((room, _)) = path.split_once('/') else { return flaws };
    let Some(known) = ROOMS.iter().find(|known| known.name == room) else {
        flaws.push(format!("{path}: a room that the house does not know"));
        return flaws;
    };
    let code = code_of(text);
    for (line, named) in rooms_named(path, &code) {
        if !known.may_name(&named) {
            flaws.push(format!("{path}:{line}: `{room}` names `{named}`, an arrow the wrong way"));
        }
    }
    let line_of = |byte: usize| code[..byte].matches('\n').count() + 1;
    for captures in CRATE.captures_iter(&code) {
        let name = captures.get(1).unwrap();
        for (kept, keeper) in KEPT.iter().filter(|(kept, keeper)| *kept == name.as_str() && room != *keeper) {
            flaws.push(format!("{path}:{}: only `{keeper}` names {kept}", line_of(name.start())));
        }
    }
    if !known.all_pure {
        let found = IMPURE.find_iter(&code);
        flaws.extend(found.map(|f| format!("{path}:{}: `{}` in a pure room", line_of(f.start()), f.as_str().trim())));
    }
    flaws
}

/// The text with comments and the tests at its foot blanked; lines keep their numbers.
fn code_of(text: &str) -> String {
    let lines: Vec<&str> = text.lines().collect();
    let tests = (0..lines.len()).find(|&at| {
        let mut after = lines[at..].iter().skip(1).skip_while(|line| line.starts_with("#["));
        let is_for_tests = ["#[cfg(test)]", "#[cfg(all(test"].iter().any(|start| lines[at].starts_with(start));
        is_for_tests && after.next().is_some_and(|line| TEST_MODULE.is_match(line))
    });
    let code = lines[..tests.unwrap_or(lines.len())].iter();
    code.map(|line| line.split("//").next().unwrap_or("")).collect::<Vec<_>>().join("\n")
}

/// Rooms that a path names, with the line it begins on: `crate::room`, `crate::{room, ...}`, or `super` up to the root.
fn rooms_named(path: &str, code: &str) -> Vec<(usize, String)> {
    let depth = path.split('/').count() - usize::from(path.ends_with("mod.rs"));
    let mut found = Vec::new();
    for captures in ROOT_PATH.captures_iter(code) {
        let (whole, head, next) = (captures.get(0).unwrap(), &captures[1], &captures[2]);
        if head != "crate" && head.matches("super").count() < depth {
            continue;
        }
        let line = code[..whole.start()].matches('\n').count() + 1;
        if next != "{" {
            found.push((line, next.to_owned()));
            continue;
        }
        // The first word of every entry of the braces.
        let (mut level, mut word, mut fresh) = (0, String::new(), true);
        for letter in code[whole.end()..].chars() {
            match letter {
                '{' => level += 1,
                '}' if level == 0 => break,
                '}' => level -= 1,
                _ => {}
            }
            if letter.is_alphanumeric() || letter == '_' {
                if fresh && level == 0 {
                    word.push(letter);
                }
            } else if level == 0 && letter == ',' {
                found.push((line, std::mem::take(&mut word)));
                fresh = true;
            } else if !word.is_empty() {
                fresh = false;
            }
        }
        found.push((line, word));
    }
    found
}

/// Paths of one machine, by line.
fn machine_paths(path: &str, text: &str) -> Vec<String> {
    let lines = (1..).zip(text.lines()).filter(|(_, line)| MACHINE_PATH.is_match(line));
    lines.map(|(line, text)| format!("{path}:{line}: a path of one machine: {}", text.trim())).collect()
}

/// All files below a folder, or the file itself, sorted.
fn files_below(path: &Path) -> Vec<PathBuf> {
    if path.is_file() {
        return vec![path.to_owned()];
    }
    let Ok(entries) = std::fs::read_dir(path) else { return Vec::new() };
    let mut found: Vec<PathBuf> = entries.flat_map(|entry| files_below(&entry.unwrap().path())).collect();
    found.sort();
    found
}

fn house() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn relative(file: &Path, to: &Path) -> String {
    file.strip_prefix(to).unwrap().to_string_lossy().replace('\\', "/")
}

/// Files that exist for tests alone: `#[cfg(test)] mod name;`.
fn is_test_file(file: &Path) -> bool {
    let (Some(stem), Some(folder)) = (file.file_stem().and_then(|stem| stem.to_str()), file.parent()) else {
        return false;
    };
    let declared = Regex::new(&format!(r"#\[cfg\(test\)\]\s*(pub(\(\w+\))? )?mod {stem};")).unwrap();
    let parents = [folder.join("mod.rs"), folder.join("lib.rs"), folder.with_extension("rs")];
    parents.iter().filter_map(|parent| std::fs::read_to_string(parent).ok()).any(|text| declared.is_match(&text))
}

#[test]
fn every_room_knows_only_what_it_stands_on() {
    let src = house().join("src");
    let files = files_below(&src);
    assert!(files.len() > 100, "only {} files in src", files.len());
    let found: Vec<String> = files
        .iter()
        .filter(|file| file.extension().is_some_and(|extension| extension == "rs") && !is_test_file(file))
        .flat_map(|file| flaws(&relative(file, &src), &std::fs::read_to_string(file).unwrap()))
        .collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn tests_and_benches_are_of_a_readable_length() {
    for file in ["tests", "benches"].into_iter().flat_map(|folder| files_below(&house().join(folder))) {
        if file.extension().is_some_and(|extension| extension == "rs") {
            let lines = std::fs::read_to_string(&file).unwrap().lines().count();
            assert!(lines <= MOST_LINES, "{}: {lines} lines", file.display());
        }
    }
}

#[test]
fn nothing_names_a_path_of_one_machine() {
    let places = [
        "src",
        "tests",
        "benches",
        "configs",
        "pipelines",
        "docs",
        ".ci",
        "README.md",
        "ARCHITECTURE.md",
        "CHANGELOG.md",
        "Cargo.toml",
        "rustfmt.toml",
        ".gitignore",
    ];
    let mut read = 0;
    let mut found = Vec::new();
    for file in places.into_iter().flat_map(|place| files_below(&house().join(place))) {
        if let Ok(text) = std::fs::read_to_string(&file) {
            read += 1;
            found.extend(machine_paths(&relative(&file, house()), &text));
        }
    }
    assert!(read > 150, "only {read} files read");
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn the_checker_sees_what_is_wrong() {
    let wrong = |path: &str, text: &str, what: &str| {
        let found = flaws(path, text);
        assert!(found.len() == 1 && found[0].contains(what), "{path}: {text}: {found:?}");
    };
    wrong("motion/pose.rs", "use crate::cluster::Metric;", "motion/pose.rs:1: `motion` names `cluster`");
    wrong("formats/bvh/rows.rs", "\nuse super::super::super::flow::run;", "rows.rs:2: `formats` names `flow`");
    wrong("formats/bvh/mod.rs", "use super::super::annotate::Gait;", "`formats` names `annotate`");
    wrong("annotate/gait.rs", "use crate::{motion::{Poses, cluster}, synthesis};", "`annotate` names `synthesis`");
    wrong("annotate/gait.rs", "fn f() -> crate::procedural::Truth {}", "`annotate` names `procedural`");
    wrong("corpus/read.rs", "use crate::plan::Plan;", "`corpus` names `plan`");
    wrong("inputs/find.rs", "use crate::plan::Plan;", "`inputs` names `plan`");
    wrong("flow/run.rs", "use crate::cli::main;", "`flow` names `cli`");
    wrong("corpus/read.rs", "use timely::dataflow::Scope;", "only `flow` names timely");
    wrong("flow/run.rs", "let batch = arrow::array::Float32Array::from(x);", "only `corpus` names arrow");
    wrong("flow/run.rs", "use ::parquet::file::reader;", "only `corpus` names parquet");
    wrong("plan/load.rs", "use clap;", "only `cli` names clap");
    wrong("cli/strip.rs", "use plotters::prelude::RGBColor;", "only `picture` names plotters");
    wrong("motion/pose.rs", "use std::time::Instant;", "`std::time` in a pure room");
    wrong("motion/pose.rs", "use std::{\n    fmt,\n    fs,\n};", "fs` in a pure room");
    wrong("motion/pose.rs", "// quiet\n\nfn f() { std::thread::spawn(g); }", "motion/pose.rs:3: `std::thread`");
    wrong("cluster/tree.rs", "fn f() { println!(); }", "`println!` in a pure room");
    wrong("cluster/tree.rs", "let x = angle.sin();", "`.sin(` in a pure room");
    wrong("cluster/util.rs", "", "a name that says nothing");
    wrong("cellar/wine.rs", "", "a room that the house does not know");
    wrong("cluster/tree.rs", &"\n".repeat(601), "601 lines");
}

#[test]
fn the_checker_leaves_alone_what_is_right() {
    for (path, text) in [
        ("motion/pose.rs", "use super::clip::Clip;\n//! as crate::flow says\nuse crate::motion::Clip;"),
        ("formats/bvh/rows.rs", "use super::super::text::Text; // use crate::flow"),
        ("cluster/tree.rs", "use crate::annotate::Gait;\n#[cfg(test)]\nmod tests {\n    use crate::cli;\n println!();"),
        ("motion/kernels.rs", "#[cfg(all(test, unix))]\n#[expect(x)]\nmod tests {\n    fn f() { eprintln!(); }"),
        ("plan/config.rs", "use crate::inputs::InputSettings;"),
        ("corpus/write.rs", "use arrow::array::Array;\nuse parquet::basic;"),
        ("picture/canvas.rs", "use plotters::coord::Shift;"),
        ("flow/run.rs", "use std::time::Instant; let x = super::lane::timely_order();"),
        ("procedural/path.rs", "libm::sin(x); x.sin_like(); std::io::Write::write(&mut bytes)"),
        ("lib.rs", "pub mod flow;"),
    ] {
        assert_eq!(flaws(path, text), Vec::<String>::new(), "{path}");
    }
}

#[test]
fn the_checker_knows_paths_of_one_machine() {
    for root in ["work", "root", "home", "tmp"] {
        assert_eq!(machine_paths("a.md", &format!("see `/{root}/corpus`")).len(), 1);
        assert_eq!(machine_paths("a.rs", &format!("let folder = \"/{root}\";")).len(), 1);
        assert_eq!(machine_paths("a.md", &format!("target/{root}/x, ../{root}/y, https://a.b/{root}/z")).len(), 0);
    }
}
