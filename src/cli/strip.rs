//! A clip as a strip of stick figures; a made clip below its base and its donor.

use super::numbers::counted;
use super::overview::there;
use crate::annotate::FrameLabels;
use crate::corpus::{Catalog, ClipRow, CorpusError, Store, read_made};
use crate::motion::Poses;
use crate::motion::kinematics::poses;
use crate::picture::{Layout, Strip, View, spread, strips};
use std::ops::Range;

/// Figures of a strip.
const FIGURES: usize = 14;

/// Positions and contacts of a clip, and what to draw of it.
struct Drawing<'a> {
    title: String,
    row: &'a ClipRow,
    poses: Poses,
    contacts: Option<[Vec<bool>; 2]>,
    frames: Vec<usize>,
}

/// A picture, and what is on it, in words.
pub(super) struct Drawn {
    pub(super) svg: String,
    pub(super) words: String,
}

/// Draws the clip.
pub(super) fn draw(row: &ClipRow, clips: &[ClipRow], store: &Store, catalog: &Catalog) -> Result<Drawn, CorpusError> {
    let mut drawings = Vec::new();
    let mut own_frames = 0..row.frames;
    if let Some(recipe) = &row.recipe {
        let made = there(read_made(store))?.unwrap_or_default().into_iter().find(|made| made.recipe == *recipe);
        let ranges = made.map_or([None, None], |made| [made.base_range, made.donor_range]);
        let ranges = ranges.map(|ends| ends.map(|[first, end]| first..end));
        for ((word, id), frames) in ["base", "donor"].into_iter().zip(&row.parents).zip(&ranges) {
            // A parent may have been pruned since.
            if let Some(parent) = clips.iter().find(|clip| clip.clip_id == *id) {
                let frames = frames.clone().unwrap_or(0..parent.frames);
                drawings.push(drawing(format!("{word}  {}", parent.full_name()), parent, frames, catalog)?);
            }
        }
        // A made clip has the frames of its base.
        let [base, _] = ranges;
        own_frames = base.unwrap_or(own_frames);
    }
    let word = if row.origin.is_made() { "graft  " } else { "" };
    drawings.push(drawing(format!("{word}{}", row.full_name()), row, own_frames, catalog)?);
    let mut drawn = Vec::new();
    for drawing in &drawings {
        let skeleton = catalog.shard_of(drawing.row.clip_id)?.skeleton(drawing.row.clip_id)?;
        drawn.push(Strip {
            title: &drawing.title,
            poses: &drawing.poses,
            skeleton: &skeleton.body,
            roles: &skeleton.roles,
            rate_hz: drawing.row.rate_hz,
            frames: &drawing.frames,
            contacts: drawing.contacts.as_ref().map(|[left, right]| [left.as_slice(), right.as_slice()]),
            ground_m: drawing.row.labels.ground_height_m.map_or_else(|| lowest(&drawing.poses), f64::from),
            view: View::Side,
            layout: Layout::Row,
        });
    }
    let figures: usize = drawings.iter().map(|drawing| drawing.frames.len()).sum();
    let words = [counted(drawings.len() as u64, "strip"), counted(figures as u64, "figure")].join(", ");
    Ok(Drawn { svg: strips(&drawn), words })
}

fn drawing<'a>(
    title: String,
    row: &'a ClipRow,
    frames: Range<u32>,
    catalog: &Catalog,
) -> Result<Drawing<'a>, CorpusError> {
    let shard = catalog.shard_of(row.clip_id)?;
    let poses = match there(shard.poses(row.clip_id))? {
        Some(poses) => poses,
        // The table may have been left out of the corpus.
        None => poses(&shard.motion(row.clip_id)?),
    };
    let labels = there(shard.labels(row.clip_id))?.flatten();
    let frames = spread(frames.start as usize, frames.end as usize, FIGURES);
    Ok(Drawing { title, row, poses, contacts: labels.as_ref().map(contacts), frames })
}

fn contacts(labels: &FrameLabels) -> [Vec<bool>; 2] {
    [0, 1].map(|foot| labels.stance[foot].iter().map(|stance| stance.unwrap_or(false)).collect())
}

/// Where nobody knows the ground it is at the lowest point.
fn lowest(poses: &Poses) -> f64 {
    let low = poses.world.iter().map(|point| point.y).fold(f64::INFINITY, f64::min);
    if low.is_finite() { low } else { 0.0 }
}
