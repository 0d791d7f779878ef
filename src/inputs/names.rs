//! Names of clips: the path below the input folder without extension, unique within a source.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fmt::Write;
use std::path::Path;

/// A path component as text. Bytes that are no text and control characters are written as `\x1F`, so that
/// different names stay different and one name stays on one line.
pub(crate) fn text_of(name: &OsStr) -> String {
    let mut text = String::new();
    for chunk in name.as_encoded_bytes().utf8_chunks() {
        for character in chunk.valid().chars() {
            match character.is_control() {
                true => escape(&mut text, character.encode_utf8(&mut [0; 4]).as_bytes()),
                false => text.push(character),
            }
        }
        escape(&mut text, chunk.invalid());
    }
    text
}

/// A relative path as text, with `/` between its components.
pub(crate) fn path_text(below: &Path) -> String {
    below.iter().map(text_of).collect::<Vec<_>>().join("/")
}

/// Names for the paths (relative, sorted): without extension where that is unique, else with it, else with `#2`.
pub(crate) fn clip_names(paths: &[&Path]) -> Vec<String> {
    let whole: Vec<String> = paths.iter().map(|path| path_text(path)).collect();
    let mut names: Vec<String> = paths.iter().map(|path| path_text(&path.with_extension(""))).collect();
    // A name with its extension may be another's without: `a.bvh.bvh` beside `a.bvh` and `a.amc`.
    loop {
        let mut uses: BTreeMap<&str, usize> = BTreeMap::new();
        for name in &names {
            *uses.entry(name).or_default() += 1;
        }
        let clash: Vec<usize> =
            (0..names.len()).filter(|&index| uses[names[index].as_str()] > 1 && names[index] != whole[index]).collect();
        if clash.is_empty() {
            break;
        }
        for index in clash {
            names[index].clone_from(&whole[index]);
        }
    }
    // Left over: bytes that are no text beside their own escape.
    unique(names)
}

/// Makes names unique in their order: `#2`, `#3` ... on repeats.
pub(crate) fn unique(names: Vec<String>) -> Vec<String> {
    let mut taken: BTreeMap<String, usize> = names.iter().map(|name| (name.clone(), 0)).collect();
    let mut result = Vec::with_capacity(names.len());
    for name in names {
        let mut uses = taken.get(&name).copied().unwrap_or(0) + 1;
        let mut own = name.clone();
        if uses > 1 {
            own = format!("{name}#{uses}");
            while taken.contains_key(&own) {
                uses += 1;
                own = format!("{name}#{uses}");
            }
            taken.insert(own.clone(), 1);
        }
        taken.insert(name, uses);
        result.push(own);
    }
    result
}

fn escape(text: &mut String, bytes: &[u8]) {
    for byte in bytes {
        write!(text, "\\x{byte:02X}").expect("writing to a String can't fail");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(paths: &[&str]) -> Vec<String> {
        clip_names(&paths.iter().map(Path::new).collect::<Vec<_>>())
    }

    #[test]
    fn the_extension_goes_where_the_name_stays_unique() {
        assert_eq!(names(&["01/01_01.amc", "walk.bvh"]), ["01/01_01", "walk"]);
        assert_eq!(names(&["walk.amc", "walk.bvh", "x/walk.bvh"]), ["walk.amc", "walk.bvh", "x/walk"]);
        assert_eq!(names(&["walk.BVH", "walk.bvh"]), ["walk.BVH", "walk.bvh"]);
        assert_eq!(names(&["take.1.bvh", "take.2.bvh"]), ["take.1", "take.2"]);
    }

    #[test]
    fn a_kept_extension_may_not_take_anothers_name() {
        assert_eq!(names(&["a.amc", "a.bvh", "a.bvh.bvh"]), ["a.amc", "a.bvh", "a.bvh.bvh"]);
        assert_eq!(names(&["a.bvh", "a.bvh.bvh"]), ["a", "a.bvh"]);
    }

    #[test]
    fn repeats_are_numbered_around_names_that_are_there() {
        let owned = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect();
        assert_eq!(unique(owned(&["cmu", "cmu", "cmu"])), ["cmu", "cmu#2", "cmu#3"]);
        assert_eq!(unique(owned(&["cmu", "cmu", "cmu#2"])), ["cmu", "cmu#3", "cmu#2"]);
        assert_eq!(unique(owned(&["a", "b"])), ["a", "b"]);
    }

    #[cfg(unix)]
    #[test]
    fn bytes_that_are_no_text_are_written_out() {
        use std::os::unix::ffi::OsStrExt;
        assert_eq!(text_of(OsStr::from_bytes(b"take\xff\n1\xc3\xa9")), "take\\xFF\\x0A1é");
        let (raw, spelt) = (Path::new(OsStr::from_bytes(b"\xff.bvh")), Path::new("\\xFF.bvh"));
        assert_eq!(clip_names(&[spelt, raw]), ["\\xFF.bvh", "\\xFF.bvh#2"]);
    }
}
