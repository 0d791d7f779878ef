//! Frames a second of features, contacts and gait on one core, positions given.
//!
//! Made people (`synth`); parsing, kinematics and writing are outside the clock. The plants of every clip are held
//! against the plan that it was made from before anything is timed; the best of several rounds counts, since other
//! programs only ever slow it down.
//!
//! ```text
//! cargo bench --bench labels
//! ```
#![expect(clippy::unwrap_used, reason = "a bench")]

use motionmill::annotate::features::features_about;
use motionmill::annotate::root::{RootTrack, root_track};
use motionmill::annotate::{Settings, annotate_about};
use motionmill::flow::settings::shipped_names;
use motionmill::motion::kinematics::poses;
use motionmill::motion::{Format, Poses, RoleMap, assign_roles};
use motionmill::procedural::{Disturbance, Draws, corpus, disturb, make};
use std::hint::black_box;
use std::time::{Duration, Instant};

const CLIPS: usize = 40;
const ROUNDS: usize = 12;

/// A clip as the stages find it.
struct Posed {
    poses: Poses,
    roles: RoleMap,
    rate_hz: f64,
    root: RootTrack,
}

fn main() {
    let names = shipped_names();
    let (mut clips, mut frames, mut right) = (Vec::new(), 0, 0.0);
    for spec in corpus(CLIPS, 7) {
        let made = make(&spec, Format::Amc).unwrap();
        let poses = poses(&made.clip);
        let (roles, ..) = assign_roles(&made.clip.skeleton, &names, Some(&poses.world[..poses.n_points]));
        let rate_hz = made.clip.rate_hz;
        let root = root_track(&poses, &roles, rate_hz);
        let found = annotate_about(&root, &poses, &roles, rate_hz, &Settings::default()).frames;
        let agree = made.truth.left_contact.iter().zip(&found.stance[0]).filter(|(truth, own)| **own == Some(**truth));
        right += agree.count() as f64;
        frames += poses.n_frames;
        clips.push(Posed { poses, roles, rate_hz, root });
    }
    assert!(right / frames as f64 > 0.95, "the labels are not those of the plan: {right} of {frames} frames");
    println!("{CLIPS} clips, {frames} frames, {:.3} of the left foot's frames as planned", right / frames as f64);
    report("root track", &clips, frames, |clip| root_track(&clip.poses, &clip.roles, clip.rate_hz).position.len());
    report("features", &clips, frames, |clip| {
        features_about(&clip.root, &clip.poses, &clip.roles, clip.rate_hz).values.len()
    });
    report("contacts and gait", &clips, frames, |clip| {
        annotate_about(&clip.root, &clip.poses, &clip.roles, clip.rate_hz, &Settings::default()).plants.len()
    });
    let noisy: Vec<Posed> = clips.iter().map(with_noise).collect();
    report("the same, 10 mm noise", &noisy, frames, |clip| {
        annotate_about(&clip.root, &clip.poses, &clip.roles, clip.rate_hz, &Settings::default()).plants.len()
    });
    report("all of it", &clips, frames, |clip| {
        let root = root_track(&clip.poses, &clip.roles, clip.rate_hz);
        let features = features_about(&root, &clip.poses, &clip.roles, clip.rate_hz);
        let labels = annotate_about(&root, &clip.poses, &clip.roles, clip.rate_hz, &Settings::default());
        features.values.len() + labels.plants.len()
    });
}

/// Noise that asks for smoothing.
fn with_noise(clip: &Posed) -> Posed {
    let mut draws = Draws::new(7, "bench", "noise");
    let poses = disturb(&clip.poses, clip.rate_hz, &Disturbance::White { sd_m: 0.01 }, &mut draws);
    Posed { poses, roles: clip.roles.clone(), root: clip.root.clone(), ..*clip }
}

fn report(name: &str, clips: &[Posed], frames: usize, work: impl Fn(&Posed) -> usize) {
    let round = || {
        let start = Instant::now();
        let done: usize = clips.iter().map(|clip| black_box(work(black_box(clip)))).sum();
        assert!(done > 0, "work was done");
        start.elapsed()
    };
    let best = (0..ROUNDS).map(|_| round()).min().unwrap_or(Duration::MAX);
    println!("{name:<22} {:>12.0} frames/s", frames as f64 / best.as_secs_f64());
}
