//! The stages of a clip as pure calls: read, parse, kinematics, features, contacts and gait.

use super::settings::RunSettings;
use super::work::{ClipOrigin, FileFacts, FileJob, Out, Text, Todo, Work};
use crate::annotate::annotate_about;
use crate::annotate::features::features_about;
use crate::annotate::root::root_track;
use crate::corpus::{Catalog, CorpusError};
use crate::formats::{Finding, Motion, Reading, read_amc, read_asf, read_bvh};
use crate::motion::bounds::{guess_unit_m, guess_up_axis};
use crate::motion::clip::snap_rate_hz;
use crate::motion::kinematics::{file_pose_of_frame, pose_of_frame, poses, poses_and_rotations};
use crate::motion::role_assign::assign_roles;
use crate::motion::{Notice, Severity, UpAxis};
use glam::DVec3;
use std::path::Path;
use std::sync::Arc;

/// A body farther away than this is nowhere: tables would hold its place to no better than 6 cm.
const FARTHEST_M: f64 = 1e6;
/// Frames a second of an AMC file where nobody says: the format has no field for it, and nearly all are CMU's.
const USUAL_AMC_RATE_HZ: f64 = 120.0;

/// Reads the clip's files.
pub(super) fn read(work: &mut Work, settings: &RunSettings) -> Result<(), Out> {
    let ClipOrigin::File(file) = &work.job().origin else { return Ok(()) };
    let limit = settings.read.limits.max_clip_bytes;
    let motion = read_file(&file.path, limit)?;
    let skeleton = file.asf.as_deref().map(|asf| read_file(asf, limit)).transpose()?.unwrap_or_default();
    work.text = Text { motion, skeleton };
    Ok(())
}

/// Parses what was read, and settles rate, unit and up axis; or takes the stored channels.
pub(super) fn parse(work: &mut Work, settings: &RunSettings, catalog: Option<&Catalog>) -> Result<(), Out> {
    let text = std::mem::take(&mut work.text);
    let job = work.job().clone();
    match &job.origin {
        ClipOrigin::Recipe(_) => Ok(()),
        ClipOrigin::Stored => take_stored(work, job.clip_id, catalog),
        ClipOrigin::Kept(kept) => {
            work.notices.clone_from(&kept.notices);
            if kept.row.is_some() {
                return take_stored(work, kept.stored_as, catalog);
            }
            let fault = work.notices.iter().position(|notice| notice.severity == Severity::Fault);
            let missing = CorpusError::NotThere { what: format!("clip {}", job.clip_id) };
            Err(fault.map_or_else(|| damaged(&missing), |at| work.notices.remove(at)).into())
        }
        ClipOrigin::File(file) => {
            let motion = parse_text(file, &text, settings, &mut work.notices)?;
            work.facts = FileFacts {
                header: motion.header.clone(),
                frame_time_s: motion.frame_time_s,
                max_rounding: motion.max_rounding,
            };
            settle(work, file, motion, settings)
        }
    }
}

/// Takes the channels, the roles and the skeleton's header that the corpus has.
fn take_stored(work: &mut Work, clip_id: u32, catalog: Option<&Catalog>) -> Result<(), Out> {
    let stored = || {
        let catalog = catalog.ok_or_else(|| CorpusError::NotThere { what: "the catalog".to_owned() })?;
        let shard = catalog.shard_of(clip_id)?;
        Ok((shard.motion(clip_id)?, shard.skeleton(clip_id)?))
    };
    let (clip, skeleton) = stored().map_err(|error| damaged(&error))?;
    work.clip = Some(Arc::new(clip));
    work.roles = skeleton.roles.clone();
    work.facts.header.clone_from(&skeleton.header);
    Ok(())
}

/// World positions, and rotations where a table wants them.
pub(super) fn kinematics(work: &mut Work, settings: &RunSettings) -> Result<(), Out> {
    let poses = if settings.rotations && work.shard.todo == Todo::Everything {
        let (poses, rotations) = poses_and_rotations(work.clip());
        work.rotations = Some(rotations);
        poses
    } else {
        poses(work.clip())
    };
    // Spelt so that what is no number is no place either.
    let is_place = |point: &DVec3| point.abs().max_element() <= FARTHEST_M;
    if let Some(at) = poses.world.iter().position(|point| !is_place(point)) {
        let (frame, point) = (at / poses.n_points, at % poses.n_points);
        return Err(nowhere(work, frame, point, poses.world[at]).into());
    }
    work.poses = Some(poses);
    Ok(())
}

/// The fault of a clip that leaves the world in one of its frames.
fn nowhere(work: &Work, frame: usize, point: usize, place: DVec3) -> Notice {
    let joints = &work.clip().skeleton.joints;
    let joint = joints.get(point).map_or_else(|| "the end of a joint".to_owned(), |joint| format!("`{}`", joint.name));
    let far = place.abs().max_element();
    Notice {
        frame: Some(frame as u32),
        ..fault(
            "position-absurd",
            format!("frame {frame} of the table has {joint} {far:.3e} m away from the origin"),
            "no capture is that large: a number in the file is broken, or its unit is another, and speeds and likeness \
             of frames would come to nothing",
            "look at the clip's root channels there, or set `unit_m` of the source in the config",
        )
    }
}

/// The root's track, and the features about it.
pub(super) fn features(work: &mut Work, settings: &RunSettings) {
    let rate_hz = work.clip().rate_hz;
    let root = root_track(work.poses(), &work.roles, rate_hz);
    if settings.features && !matches!(work.shard.todo, Todo::Again { features: false, .. }) {
        work.features = features_about(&root, work.poses(), &work.roles, rate_hz);
    }
    work.root = Some(root);
}

/// Contacts, gait, plant states, and what they say of the clip.
pub(super) fn contacts(work: &mut Work, settings: &RunSettings) {
    let Some(root) = work.root.take() else { return };
    if settings.labels && !matches!(work.shard.todo, Todo::Again { labels: false, .. }) {
        let rate_hz = work.clip().rate_hz;
        work.annotated = annotate_about(&root, work.poses(), &work.roles, rate_hz, &settings.annotate);
    }
}

fn read_file(path: &Path, limit: u64) -> Result<Vec<u8>, Notice> {
    let unreadable = |error: std::io::Error| {
        fault(
            "file-unreadable",
            format!("{} can't be read: {error}", path.display()),
            "without its bytes the clip is left out; the others go on",
            "make it readable, or list the clip under `skip` in your config",
        )
    };
    let bytes = std::fs::metadata(path).map_err(unreadable)?.len();
    if bytes > limit {
        return Err(fault(
            "file-too-large",
            format!("{} has {bytes} bytes, the limit is {limit}", path.display()),
            "a clip is held in memory as a whole",
            "cut the clip, or raise `limits.max_clip_bytes`",
        ));
    }
    std::fs::read(path).map_err(unreadable)
}

fn parse_text(
    file: &FileJob,
    text: &Text,
    settings: &RunSettings,
    notices: &mut Vec<Notice>,
) -> Result<Motion, Notice> {
    let mut options = settings.read.clone();
    options.position_rule = file.settings.position_channels;
    let is_amc = file.path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("amc"));
    let reading = if is_amc {
        let in_skeleton = |mut notice: Notice| {
            notice.message = format!("in the skeleton file: {}", notice.message);
            notice
        };
        let asf = read_asf(&text.skeleton, &options).map_err(|finding| in_skeleton(finding.notice()))?;
        notices.extend(asf.notices().into_iter().map(in_skeleton));
        read_amc(&text.motion, &asf.value, &options)
    } else {
        read_bvh(&text.motion, &options)
    };
    let reading: Reading<Motion> = reading.map_err(|finding: Finding| finding.notice())?;
    notices.extend(reading.notices());
    Ok(reading.value)
}

/// Rate, unit, up axis and roles: from the config, else from the file, else guessed with a note.
fn settle(work: &mut Work, file: &FileJob, motion: Motion, settings: &RunSettings) -> Result<(), Out> {
    let said = &file.settings;
    let rate_hz = match (said.rate_hz, motion.frame_time_s) {
        (Some(rate_hz), _) => rate_hz,
        (None, Some(frame_time_s)) => snap_rate_hz(frame_time_s),
        (None, None) => {
            work.notices.push(note(
                "rate-guessed",
                format!("the file does not say its rate; {USUAL_AMC_RATE_HZ} Hz is taken, the rate of CMU's captures"),
                "speeds, and so plants and gaits, depend on it",
                "set `rate_hz` of the source in the config",
            ));
            USUAL_AMC_RATE_HZ
        }
    };
    let unit_m = said.unit_m.or(motion.unit_m);
    let mut clip = motion.into_clip(rate_hz, unit_m.unwrap_or(1.0), said.up.unwrap_or(UpAxis::Y));
    let has_frames = clip.n_frames > 0;
    if unit_m.is_none() || said.up.is_none() {
        // Guesses need roles, and roles a first pose, whose unit does not matter to them.
        let first = has_frames.then(|| file_pose_of_frame(&clip, 0));
        let (roles, ..) = assign_roles(&clip.skeleton, &settings.names, first.as_deref());
        if unit_m.is_none() {
            let (guessed_m, notice) = guess_unit_m(&clip, &roles);
            clip.unit_m = guessed_m;
            work.notices.push(notice);
        }
        if said.up.is_none() {
            let (up, notice) = guess_up_axis(&clip, &roles);
            clip.up = up;
            work.notices.extend(notice);
        }
    }
    let first = has_frames.then(|| pose_of_frame(&clip, 0));
    let (roles, _, notices) = assign_roles(&clip.skeleton, &settings.names, first.as_deref());
    work.notices.extend(notices);
    work.roles = roles;
    work.clip = Some(Arc::new(clip));
    Ok(())
}

fn damaged(error: &CorpusError) -> Notice {
    fault(
        "corpus-damaged",
        error.to_string(),
        "the stored channels can't be read, so nothing can be made of them",
        "run `motionmill verify`, delete the commit record of the shard and run again",
    )
}

fn fault(kind: &str, message: String, why: &str, remedy: &str) -> Notice {
    notice(Severity::Fault, kind, message, why, remedy)
}

fn note(kind: &str, message: String, why: &str, remedy: &str) -> Notice {
    notice(Severity::Note, kind, message, why, remedy)
}

fn notice(severity: Severity, kind: &str, message: String, why: &str, remedy: &str) -> Notice {
    Notice {
        severity,
        kind: kind.to_owned(),
        line: None,
        frame: None,
        count: 1,
        message,
        why: why.to_owned(),
        remedy: remedy.to_owned(),
    }
}
