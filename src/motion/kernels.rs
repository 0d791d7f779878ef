//! Runs a [`PoseProgram`] over a clip, eight frames at a time, in the widest vector registers of the processor.
//!
//! The only place in this room with `unsafe`: the same loop is compiled for AVX2 and AVX-512 as well, and called
//! when the processor has them. All three give the same bits (see the test), since none may fuse or reorder.

use super::clip::Clip;
use super::lanes::{IDENTITY, LANES, Lanes, LanesMatrix, LanesPoint, place, sincos, turn, turn_fixed};
use super::pose_program::{Factor, PointStep, PoseProgram, TurnStep};
use super::skeleton::AngleUnit;
use glam::DVec3;

/// World positions `[frame][point]`, metres.
#[cfg_attr(target_arch = "x86_64", expect(unsafe_code, reason = "calls into code for features that were detected"))]
pub(super) fn run(program: &PoseProgram, clip: &Clip) -> Vec<DVec3> {
    #[cfg(target_arch = "x86_64")]
    {
        if has_avx512() {
            // SAFETY: the processor has every feature that `run_avx512` enables.
            return unsafe { run_avx512(program, clip) };
        }
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has the feature that `run_avx2` enables.
            return unsafe { run_avx2(program, clip) };
        }
    }
    run_baseline(program, clip)
}

fn run_baseline(program: &PoseProgram, clip: &Clip) -> Vec<DVec3> {
    run_blocks(program, clip)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn run_avx2(program: &PoseProgram, clip: &Clip) -> Vec<DVec3> {
    run_blocks(program, clip)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl")]
fn run_avx512(program: &PoseProgram, clip: &Clip) -> Vec<DVec3> {
    run_blocks(program, clip)
}

#[cfg(target_arch = "x86_64")]
fn has_avx512() -> bool {
    use std::arch::is_x86_feature_detected as has;
    has!("avx512f") && has!("avx512dq") && has!("avx512vl")
}

#[inline(always)]
fn run_blocks(program: &PoseProgram, clip: &Clip) -> Vec<DVec3> {
    let mut world = Vec::with_capacity(clip.n_frames * program.points.len());
    let mut rotations = vec![IDENTITY; program.turns.len()];
    let mut points = vec![[Lanes::all(0.0); 3]; program.points.len()];
    for start in (0..clip.n_frames).step_by(LANES) {
        // The last block repeats the last frame in the lanes that are left over.
        let rows: [&[f32]; LANES] = core::array::from_fn(|lane| clip.frame((start + lane).min(clip.n_frames - 1)));
        for (index, step) in program.turns.iter().enumerate() {
            rotations[index] = turned(step, &rotations, &rows, program.angle_unit);
        }
        for (index, step) in program.points.iter().enumerate() {
            points[index] = placed(step, &points, &rotations, &rows);
        }
        for lane in 0..LANES.min(clip.n_frames - start) {
            world.extend(points.iter().map(|[x, y, z]| DVec3::new(x.0[lane], y.0[lane], z.0[lane])));
        }
    }
    world
}

#[inline(always)]
fn turned(step: &TurnStep, rotations: &[LanesMatrix], rows: &[&[f32]; LANES], unit: AngleUnit) -> LanesMatrix {
    let mut matrix = step.from.map_or(IDENTITY, |from| rotations[from]);
    for factor in &step.factors {
        match factor {
            Factor::Turn(axis, channel) => {
                let (sin, cos) = sincos(column(rows, *channel), unit);
                turn(&mut matrix, *axis, sin, cos);
            }
            Factor::Fixed(fixed) => turn_fixed(&mut matrix, fixed),
        }
    }
    matrix
}

#[inline(always)]
fn placed(step: &PointStep, points: &[LanesPoint], rotations: &[LanesMatrix], rows: &[&[f32]; LANES]) -> LanesPoint {
    let mut offset = step.offset.map(Lanes::all);
    for (channel, scales) in &step.moves {
        let value = column(rows, *channel);
        for (sum, scale) in offset.iter_mut().zip(scales) {
            sum.add_scaled(value, *scale);
        }
    }
    let base = step.base.map_or([Lanes::all(0.0); 3], |base| points[base]);
    place(&base, step.rotation.map_or(&IDENTITY, |rotation| &rotations[rotation]), &offset)
}

/// One channel in every frame of the block.
#[inline(always)]
fn column(rows: &[&[f32]; LANES], channel: usize) -> Lanes {
    Lanes(core::array::from_fn(|lane| f64::from(rows[lane][channel])))
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::*;
    use crate::motion::sample_bodies::random_clip;

    fn bits(world: &[DVec3]) -> Vec<[u64; 3]> {
        world.iter().map(|point| point.to_array().map(f64::to_bits)).collect()
    }

    #[test]
    #[expect(unsafe_code, reason = "calls into code for features that were detected")]
    fn every_width_of_register_gives_the_same_bits() {
        let (avx2, avx512) = (std::arch::is_x86_feature_detected!("avx2"), has_avx512());
        eprintln!("compared with the baseline: AVX2 {avx2}, AVX-512 {avx512}");
        for seed in 0..200 {
            let clip = random_clip(seed);
            let Some(program) = PoseProgram::of(&clip) else { panic!("seed {seed}: not for the kernel") };
            let baseline = bits(&run_baseline(&program, &clip));
            if avx2 {
                // SAFETY: the processor has the feature that `run_avx2` enables.
                assert_eq!(bits(&unsafe { run_avx2(&program, &clip) }), baseline, "seed {seed}, AVX2");
            }
            if avx512 {
                // SAFETY: the processor has every feature that `run_avx512` enables.
                assert_eq!(bits(&unsafe { run_avx512(&program, &clip) }), baseline, "seed {seed}, AVX-512");
            }
        }
    }
}
