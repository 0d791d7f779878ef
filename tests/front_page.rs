//! The picture of the README is one that the program makes, byte for byte.

use motionmill::annotate::{Settings, annotate};
use motionmill::motion::kinematics::poses;
use motionmill::motion::{Clip, Format, NameTables};
use motionmill::picture::{Layout, Strip, View, spread, strips};
use motionmill::procedural::{corpus, make};
use motionmill::synthesis::{ActionSettings, GraftSettings, Recipe, Subject, making};
use std::path::Path;
use std::sync::Arc;

const FIGURES: usize = 15;

/// Set `MOTIONMILL_UPDATE` to write the picture anew; look at it before committing it.
#[test]
fn the_picture_is_made_by_the_program() {
    let tables = NameTables::from_toml(&[("cmu-asf", include_str!("../configs/skeletons/cmu-asf.toml"))]).unwrap();
    let specs = corpus(20, 1);
    let subject = |name: &str| {
        let spec = specs.iter().find(|spec| spec.name == name).unwrap();
        let clip = make(spec, Format::Amc).unwrap().clip;
        let (_, roles) = tables.best(&clip.skeleton).unwrap();
        Subject::new(Arc::new(clip), &roles).unwrap()
    };
    let (base, donor) = (subject("walk_01"), subject("stand_raise_left_01"));
    let recipe = Recipe {
        recipe: "picture".into(),
        kind: "graft".into(),
        base: "walk_01".into(),
        donor: Some("stand_raise_left_01".into()),
        chains: vec!["arm_left".into()],
        alternate: Some(0),
        options: "{}".into(),
        seed: 1,
        rule: "walk<-stand".into(),
        cell: None,
    };
    let made = making::make(&recipe, &base, &donor, &ActionSettings::default(), &GraftSettings::default()).unwrap();
    assert!(made.donor_range[1] - made.donor_range[0] > 30, "{:?}", made.donor_range);
    let roles = tables.best(&made.clip.skeleton).unwrap().1;
    let shown: [(&str, &Clip); 3] = [
        ("base: walk_01", &base.clip),
        ("donor: stand_raise_left_01", &donor.clip),
        ("graft: the base's legs, path and timing, the donor's left arm", &made.clip),
    ];
    let prepared = shown.map(|(title, clip)| {
        let poses = poses(clip);
        let labels = annotate(&poses, &roles, clip.rate_hz, &Settings::default());
        let planted = |foot: usize| labels.frames.stance[foot].iter().map(|&on| on == Some(true)).collect::<Vec<_>>();
        (title, clip, [planted(0), planted(1)], spread(0, clip.n_frames, FIGURES), poses)
    });
    let drawn: Vec<Strip<'_>> = prepared
        .iter()
        .map(|(title, clip, contacts, frames, poses)| Strip {
            title,
            poses,
            skeleton: &clip.skeleton,
            roles: &roles,
            rate_hz: clip.rate_hz,
            frames,
            contacts: Some([&contacts[0], &contacts[1]]),
            ground_m: 0.0,
            view: View::Side,
            layout: Layout::Row,
        })
        .collect();
    let picture = strips(&drawn);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/graft.svg");
    if std::env::var_os("MOTIONMILL_UPDATE").is_some() {
        std::fs::write(&path, &picture).unwrap();
    }
    assert!(picture.len() < 200_000, "{} bytes", picture.len());
    assert!(std::fs::read_to_string(&path).unwrap() == picture, "docs/graft.svg differs: see MOTIONMILL_UPDATE");
}
