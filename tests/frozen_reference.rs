//! The judge's reference: frozen by the first enrichment, made anew when it is lost, refused when it is damaged (DESIGN 4).
//! That it is the same for any number of workers and kills is in `dataflow`, whose corpora have one.

use crate::running::{Reference, copy, files_below, flip, run, start_two};
use motionmill::corpus::{REFERENCE, Wrong, open_to_read, read_made, verify};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// The manifest's digest of the reference, and its layouts.
fn reference_of(corpus: &Path) -> (String, Value) {
    let (store, manifest) = open_to_read(corpus).unwrap();
    let bytes = store.read(REFERENCE).unwrap().unwrap();
    let digest = manifest.reference.unwrap();
    assert_eq!(digest, blake3::hash(&bytes).to_string());
    assert_eq!(digest, manifest.tables[REFERENCE].blake3);
    assert!(verify(&store).unwrap().findings.is_empty());
    (digest, serde_json::from_slice::<Value>(&bytes).unwrap()["layouts"].clone())
}

#[test]
fn every_judged_clip_is_held_against_it_and_it_is_made_anew_when_it_is_lost() {
    let reference = Reference::get();
    let [a, b] = &reference.inputs();
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("corpus");
    copy(&reference.folder.path().join("corpus"), &out);
    let (_, layouts) = reference_of(&out);
    assert_eq!(layouts.as_object().unwrap().len(), 2, "AMC and BVH");
    let judged: Vec<_> = read_made(&open_to_read(&out).unwrap().0)
        .unwrap()
        .into_iter()
        .filter(|made| !made.figures.is_empty())
        .collect();
    assert!(judged.len() > 20);
    for made in &judged {
        let figure = made.figures.iter().find(|figure| figure.name == "limit_excess").unwrap();
        assert!(figure.own.is_some() && figure.base.is_some() && figure.donor.is_some(), "{made:?}");
    }
    let modified = || fs::metadata(&files_below(&out.join("commits"))[0]).unwrap().modified().unwrap();
    let before = modified();
    fs::remove_file(out.join(REFERENCE)).unwrap();
    run("enrich", &[a, b], &out, &["-w", "2"]).with(0);
    reference.equals(&out, "after the reference was deleted");
    assert_eq!(modified(), before, "the same reference: nothing was judged anew");
}

#[test]
fn a_damaged_reference_ends_the_run_everywhere_until_it_is_deleted() {
    let reference = Reference::get();
    let [a, b] = &reference.inputs();
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("corpus");
    copy(&reference.folder.path().join("corpus"), &out);
    flip(&out.join(REFERENCE));
    let found = verify(&open_to_read(&out).unwrap().0).unwrap().findings;
    assert_eq!(found.iter().map(|f| (f.path.as_str(), &f.what)).collect::<Vec<_>>(), [(REFERENCE, &Wrong::Changed)]);
    run("enrich", &[a, b], &out, &["-w", "3"]).fails_with("reference.json: damaged");
    for process in start_two(folder.path(), "enrich", &[a, b], &out, [&[], &[]]) {
        process.end().fails_with("reference.json: damaged");
    }
    fs::remove_file(out.join(REFERENCE)).unwrap();
    run("enrich", &[a, b], &out, &["-w", "2"]).with(0);
    reference.equals(&out, "after the damaged reference was deleted");
}

#[test]
fn growth_enters_new_layouts_and_leaves_what_is_frozen() {
    let reference = Reference::get();
    let [a, b] = &reference.inputs();
    let folder = tempfile::tempdir().unwrap();
    let (input, out) = (folder.path().join("a"), folder.path().join("corpus"));
    copy(a, &input);
    let amc = |path: &std::path::PathBuf| path.extension().is_some_and(|extension| extension == "amc");
    let later = files_below(&input).into_iter().rfind(amc).unwrap();
    let aside = folder.path().join("aside");
    fs::rename(&later, &aside).unwrap();
    run("enrich", &[&input], &out, &["-w", "2"]).with(0);
    let (first_digest, first) = reference_of(&out);
    fs::rename(&aside, &later).unwrap();
    run("enrich", &[&input, b], &out, &["-w", "2"]).with(0);
    let (grown_digest, grown) = reference_of(&out);
    let (_, whole) = reference_of(&reference.folder.path().join("corpus"));
    assert_eq!((first.as_object().unwrap().len(), grown.as_object().unwrap().len()), (1, 2));
    for (layout, ranges) in grown.as_object().unwrap() {
        match first.get(layout) {
            Some(frozen) => {
                assert_eq!(ranges, frozen, "{layout}");
                assert_ne!(ranges, &whole[layout], "{layout}: the clip that came later would have changed it");
            }
            None => assert_eq!(ranges, &whole[layout], "{layout}"),
        }
    }
    assert_ne!(first_digest, grown_digest);
    // Lost, it is that of all clips; and what it judges is judged anew.
    fs::remove_file(out.join(REFERENCE)).unwrap();
    run("enrich", &[&input, b], &out, &["-w", "2"]).with(0);
    assert_eq!(reference_of(&out).1, whole);
}
