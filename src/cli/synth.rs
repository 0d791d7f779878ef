//! `synth`: procedural captures as files, with the truth about every frame beside them.

use super::Ending;
use super::args::{Synth, TextFormat};
use super::numbers::{counted, grouped};
use super::output::{say, tell};
use crate::formats::{WriteError, write_amc, write_bvh};
use crate::motion::Format;
use crate::motion::kinematics::poses;
use crate::procedural::{self, ClipSpec, Disturbance, Draws, MakeError, SyntheticClip};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Why captures could not be made.
#[derive(Debug, thiserror::Error)]
pub(super) enum SynthError {
    #[error("{0}")]
    Make(#[from] MakeError),
    #[error("{0}")]
    Write(#[from] WriteError),
    #[error(
        "--noise-mm needs --format bvh\n  why: an AMC file has angles only, so its bones can't leave each other\n  try: --format bvh"
    )]
    NoiseFormat,
    #[error("{}: {source}\n  why: the captures are written there\n  try: --out with a folder that can be written", path.display())]
    File { path: PathBuf, source: std::io::Error },
}

/// Runs the verb.
pub(super) fn synth(args: &Synth) -> Ending {
    let format = match args.format {
        TextFormat::Bvh => Format::Bvh,
        TextFormat::Amc => Format::Amc,
    };
    let list = if args.bench { procedural::bench } else { procedural::corpus };
    match write_captures(&args.out, &list(args.clips, args.seed), format, args.noise_mm * 1e-3) {
        Ok(frames) => {
            let (clips, frames) = (counted(args.clips as u64, "clip"), grouped(frames));
            say(&format!("{clips}, {frames} frames in {}\n", args.out.display()));
            Ending::Done
        }
        Err(error) => {
            tell(&format!("error: {error}"));
            match error {
                SynthError::NoiseFormat => Ending::BadPlan,
                _ => Ending::Failed,
            }
        }
    }
}

/// Writes procedural clips below a folder, a folder a subject, and answers with the number of frames.
///
/// `noise_sd_m`: 0 to 1, of every coordinate of every joint, which then has position channels; 0 leaves the clips as made.
/// `NAME.truth.csv` beside each clip: frame, left and right foot on the ground, gait, from the footstep plan.
pub(super) fn write_captures(
    folder: &Path,
    specs: &[ClipSpec],
    format: Format,
    noise_sd_m: f64,
) -> Result<u64, SynthError> {
    let noise = Disturbance::White { sd_m: noise_sd_m };
    debug_assert!(noise.check().is_ok(), "arguments are in range: {noise_sd_m}");
    let mut frames = 0;
    for spec in specs {
        let mut made = procedural::make(spec, format)?;
        if noise_sd_m > 0.0 {
            let mut draws = Draws::new(spec.seed, &spec.name, "noise");
            let noisy = procedural::disturb(&poses(&made.clip), made.clip.rate_hz, &noise, &mut draws);
            made.clip = procedural::with_joint_positions(&made.clip, &noisy).ok_or(SynthError::NoiseFormat)?;
        }
        frames += made.clip.n_frames as u64;
        write_clip(&folder.join(&spec.subject.name), spec, &made)?;
    }
    Ok(frames)
}

fn write_clip(folder: &Path, spec: &ClipSpec, made: &SyntheticClip) -> Result<(), SynthError> {
    let put = |name: String, bytes: &[u8]| {
        let path = folder.join(name);
        let written = std::fs::create_dir_all(folder).and_then(|()| std::fs::write(&path, bytes));
        written.map_err(|source| SynthError::File { path, source })
    };
    let clip = &made.clip;
    match &made.asf {
        Some(asf) => {
            put(format!("{}.asf", spec.subject.name), asf.as_bytes())?;
            put(format!("{}.amc", made.name), &write_amc(&clip.skeleton, &clip.channels, Some(clip.rate_hz), 1)?)?;
        }
        None => {
            let text = write_bvh(&clip.skeleton, None, 1.0 / clip.rate_hz, &clip.channels)?;
            put(format!("{}.bvh", made.name), &text)?;
        }
    }
    let mut truth = "frame,left,right,gait\n".to_owned();
    for (frame, gait) in made.truth.gait.iter().enumerate() {
        let [left, right] = [made.truth.left_contact[frame], made.truth.right_contact[frame]].map(u8::from);
        // A String takes whatever is written to it.
        let _ = writeln!(truth, "{frame},{left},{right},{}", gait.name());
    }
    put(format!("{}.truth.csv", made.name), truth.as_bytes())
}
