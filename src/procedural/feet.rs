//! Feet: heel, flat, ball while a foot stands; an arc through the air between two stances.

use super::body::Sole;
use super::legs::hanging_share;
use super::path::smoothstep;
use super::plan::{Plan, Roll, Stance, Swing};
use glam::{DVec2, DVec3, Vec2Swizzles};

/// Where a foot should be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FootPose {
    /// World.
    pub(crate) ankle_m: DVec3,
    /// From +Z towards +X.
    pub(crate) yaw_rad: f64,
    /// Toes up positive, 0 flat.
    pub(crate) pitch_rad: f64,
    /// 0: `pitch_rad` holds; 1: the foot hangs from the shank at a right angle.
    pub(crate) hanging: f64,
    /// Of the toes against the ground, up positive.
    pub(crate) toes_rad: f64,
    /// 1: the toes are at `toes_rad`; 0: in line with the foot.
    pub(crate) toe_bend: f64,
}

/// The pose of a foot (0 left, 1 right) at a time.
///
/// `hips_m(time_s)` is the height of the hips: feet in a jump go up and down with them.
pub(crate) fn foot_pose(plan: &Plan, side: usize, sole: &Sole, time_s: f64, hips_m: &dyn Fn(f64) -> f64) -> FootPose {
    let stances = &plan.stances[side];
    let after = stances.partition_point(|stance| stance.strike_s <= time_s);
    let Some(before) = after.checked_sub(1) else {
        return standing(&stances[0], sole, stances[0].strike_s);
    };
    match stances.get(after) {
        Some(next) if time_s >= stances[before].lift_s => {
            swinging(plan, [&stances[before], next], sole, time_s, hips_m)
        }
        _ => standing(&stances[before], sole, time_s.min(stances[before].lift_s)),
    }
}

/// When in a push the ball begins to rise, and how far the toes tilt then, shares of the push and of its pitch.
const TIP_START: f64 = 0.5;
const TIP_SHARE: f64 = 0.65;

/// Height that a foot is lifted to when it is held up, in lengths from ankle to ball.
const HOLD_LIFT: f64 = 1.9;

fn standing(stance: &Stance, sole: &Sole, time_s: f64) -> FootPose {
    let (pitch_rad, toes_rad) = stance_pitch_rad(stance, time_s);
    FootPose {
        ankle_m: world(stance, rolled(sole, pitch_rad, toes_rad)),
        yaw_rad: stance.yaw_rad,
        pitch_rad: pitch_rad + stance.slope_rad,
        hanging: 0.0,
        toes_rad: toes_rad + stance.slope_rad,
        toe_bend: 1.0,
    }
}

/// Pitch of the foot and of its toes.
fn stance_pitch_rad(stance: &Stance, time_s: f64) -> (f64, f64) {
    let Roll { strike_pitch_rad, landing_s, push_pitch_rad, push_s } = stance.roll;
    let since_s = time_s - stance.strike_s;
    let until_s = stance.lift_s - time_s;
    if since_s < landing_s {
        let left = 1.0 - since_s / landing_s;
        (strike_pitch_rad * left * left, 0.0)
    } else if until_s < push_s {
        // Slow, quick, and slower again at the very end.
        let u = 1.0 - until_s / push_s;
        // The ball leaves the ground last but one, the tip of the toes last.
        let tip = ((u - TIP_START) / (1.0 - TIP_START)).max(0.0);
        (-push_pitch_rad * u * u * (2.0 - u), -TIP_SHARE * push_pitch_rad.max(0.0) * tip * tip)
    } else {
        (0.0, 0.0)
    }
}

/// Forward and up of the ankle, from the point on the ground that is below it when the foot is flat.
fn rolled(sole: &Sole, pitch_rad: f64, toes_rad: f64) -> DVec2 {
    let turn = |angle_rad: f64| DVec2::from(libm::sincos(angle_rad)).yx();
    if pitch_rad > 0.0 {
        DVec2::new(-sole.heel_m, 0.0) + turn(pitch_rad).rotate(DVec2::new(sole.heel_m, sole.ankle_m))
    } else {
        let tip = DVec2::new(sole.length_m + sole.toes_m, 0.0);
        let ball = tip + turn(toes_rad).rotate(DVec2::new(-sole.toes_m, sole.ball_m));
        ball + turn(pitch_rad).rotate(DVec2::new(-sole.length_m, sole.ankle_m - sole.ball_m))
    }
}

fn world(stance: &Stance, at: DVec2) -> DVec3 {
    let (sin, cos) = libm::sincos(stance.yaw_rad);
    let (rise, run) = libm::sincos(stance.slope_rad);
    let at = DVec2::new(run * at.x - rise * at.y, rise * at.x + run * at.y);
    DVec3::new(stance.place_m[0] + sin * at.x, stance.ground_m + at.y, stance.place_m[1] + cos * at.x)
}

fn swinging(plan: &Plan, [from, to]: [&Stance; 2], sole: &Sole, time_s: f64, hips_m: &dyn Fn(f64) -> f64) -> FootPose {
    const DT_S: f64 = 1e-4;
    let swing_s = to.strike_s - from.lift_s;
    let u = (time_s - from.lift_s) / swing_s;
    let start = standing(from, sole, from.lift_s);
    let earlier = standing(from, sole, from.lift_s - DT_S);
    let end = standing(to, sole, to.strike_s);
    let start_velocity = (start.ankle_m - earlier.ankle_m) / DT_S;
    let start_pitch_rate = (start.pitch_rad - earlier.pitch_rad) / DT_S;
    let gone = end.ankle_m - start.ankle_m;
    let mut pose = FootPose {
        ankle_m: start.ankle_m.lerp(end.ankle_m, smoothstep(u)),
        yaw_rad: from.yaw_rad + (to.yaw_rad - from.yaw_rad) * smoothstep(u),
        pitch_rad: hermite(u, start.pitch_rad, start_pitch_rate * swing_s, end.pitch_rad, 0.0),
        hanging: 0.0,
        toes_rad: start.toes_rad,
        toe_bend: 1.0 - smoothstep(u / 0.35),
    };
    if end.pitch_rad < end.toes_rad && from.swing != Swing::Jump {
        // Toes that strike first are bent already.
        pose.toe_bend = pose.toe_bend.max(smoothstep((u - 0.75) / 0.25));
        pose.toes_rad = start.toes_rad + (end.toes_rad - start.toes_rad) * smoothstep((u - 0.4) / 0.3);
    }
    match from.swing {
        Swing::Walk | Swing::Run => {
            let running = from.swing == Swing::Run;
            let speed = libm::sqrt(gone.x * gone.x + gone.z * gone.z) / swing_s;
            // The foot arrives moving on and down.
            let (onward, down) = if running { (0.40, 0.36) } else { (0.26, 0.11) };
            let arrival = DVec3::new(gone.x, 0.0, gone.z) / swing_s * onward
                - DVec3::Y * (down * speed + 0.8 * from.lift_m / swing_s);
            pose.ankle_m = DVec3::from_array(core::array::from_fn(|n| {
                let (v0, v1) = (start_velocity[n] * swing_s, arrival[n] * swing_s);
                hermite(u, start.ankle_m[n], v0, end.ankle_m[n], v1)
            }));
            let clearance_m = from.clearance * if running { 0.036 * speed } else { 0.012 } + from.lift_m;
            // Highest at two fifths of the swing.
            pose.ankle_m.y += clearance_m * u * u * (1.0 - u) * (1.0 - u) * (1.0 - u) * 28.935;
            pose.hanging = hanging_share(u, 0.4, 0.55);
        }
        Swing::Jump => {
            let now_m = hips_m(time_s);
            let risen = start.ankle_m.y + now_m - hips_m(from.lift_s);
            let sunk = end.ankle_m.y + now_m - hips_m(to.strike_s);
            let tuck_m = 0.25 * sole.length_m * 16.0 * u * u * (1.0 - u) * (1.0 - u);
            pose.ankle_m.y = risen + (sunk - risen) * smoothstep(u) + tuck_m;
            for n in [0, 2] {
                pose.ankle_m[n] = start.ankle_m[n] + gone[n] * (0.5 * u + 0.5 * smoothstep(u));
            }
            pose.pitch_rad = start.pitch_rad + (end.pitch_rad - start.pitch_rad) * smoothstep(u);
        }
        Swing::Stair => {
            // Up before forward, or forward before down: the edges of the treads are in the way.
            let up = gone.y > 0.0;
            let (early, late) = (smoothstep(u / 0.6), smoothstep((u - 0.3) / 0.7));
            let (onward, risen) = if up { (late, early) } else { (early, late) };
            pose.ankle_m = start.ankle_m + DVec3::new(gone.x * onward, gone.y * risen, gone.z * onward);
            pose.ankle_m.y += 0.65 * sole.length_m * 16.0 * u * u * (1.0 - u) * (1.0 - u);
            if up {
                // Drawn back while the foot gets level, or its tip would meet the riser ahead.
                let back = 0.75 * sole.length_m * 45.56 * u * u * libm::pow(1.0 - u, 4.0);
                let (sin, cos) = libm::sincos(from.yaw_rad);
                pose.ankle_m -= DVec3::new(sin, 0.0, cos) * back;
            }
            pose.hanging = hanging_share(u, 0.4, 0.55);
        }
        Swing::Hold | Swing::Hop => {
            let raised = smoothstep((time_s - from.lift_s) / 0.55) * smoothstep((to.strike_s - time_s) / 0.55);
            if from.swing == Swing::Hop {
                let at = plan.path.at(time_s);
                let [before, after] = [from.lift_s, to.strike_s].map(|t| plan.path.at(t));
                // With the body, on its way and up and down.
                let ahead = |now: f64, before: f64, after: f64| now - before - (after - before) * smoothstep(u);
                pose.ankle_m.x += ahead(at.x_m, before.x_m, after.x_m);
                pose.ankle_m.z += ahead(at.z_m, before.z_m, after.z_m);
                // Less down than up: it is not to touch the ground.
                let gone_up_m = hips_m(time_s) - hips_m(from.lift_s);
                pose.ankle_m.y += raised * (gone_up_m.max(0.4 * gone_up_m) + 0.25 * sole.length_m);
            }
            pose.ankle_m.y += raised * HOLD_LIFT * sole.length_m;
            let (sin, cos) = libm::sincos(from.yaw_rad);
            pose.ankle_m += DVec3::new(sin, 0.0, cos) * (raised * 0.05);
            pose.pitch_rad = start.pitch_rad + (end.pitch_rad - start.pitch_rad) * smoothstep(u);
            pose.hanging = 0.6 * raised;
        }
    }
    pose
}

fn hermite(u: f64, p0: f64, v0: f64, p1: f64, v1: f64) -> f64 {
    let (a, b) = (u * u * (3.0 - 2.0 * u), u * (1.0 - u));
    p0 + (p1 - p0) * a + b * (v0 * (1.0 - u) - v1 * u)
}
