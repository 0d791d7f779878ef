//! Puts the parts together: from a plan and a body to a posture a sample.

use super::arms::{ArmAction, Beat, arm_pose, arm_turns};
use super::body::{Body, Posture};
use super::carriage::Carriage;
use super::draws::Draws;
use super::feet::{FootPose, foot_pose};
use super::legs::{highest_hip_m, leg};
use super::pace::GRAVITY_MPS2;
use super::path::{GRID_HZ, Knots, gaussian, running_max};
use super::plan::Plan;
use super::skeleton::joint;
use super::style::Style;
use crate::motion::Axis;
use crate::motion::rotation::about;
use core::f64::consts::TAU;
use glam::{DQuat, DVec3};

/// Slow wandering: three sines that never repeat together, about -1 to 1.
#[derive(Clone, Debug)]
struct Wander {
    waves: [(f64, f64); 3],
}

/// A body on its way, ready to be asked for postures on the grid of its path.
pub(crate) struct Mover<'a> {
    plan: &'a Plan,
    body: &'a Body,
    style: &'a Style,
    actions: &'a [ArmAction],
    carriage: Carriage,
    feet: Vec<[FootPose; 2]>,
    /// Height of the hips over the ground, final.
    height_m: Vec<f64>,
    /// Height of the ground below the body, stairs made smooth.
    ground_m: Vec<f64>,
    wander: [Wander; 4],
    breath: (f64, f64),
}

/// Straightest leg, share of its length: beyond it the hips are lowered.
const REACH: f64 = 0.997;

impl<'a> Mover<'a> {
    pub(crate) fn new(
        plan: &'a Plan,
        body: &'a Body,
        style: &'a Style,
        actions: &'a [ArmAction],
        draws: &mut Draws,
    ) -> Mover<'a> {
        let carriage = Carriage::new(plan, body, style);
        let rate = f64::from(GRID_HZ);
        let raw = &carriage.height_m;
        let ground_m: Vec<f64> =
            (0..plan.path.n_samples()).map(|index| plan.ground_m(plan.path.time_s(index))).collect();
        let ground_m = gaussian(&ground_m, 0.1);
        let hips_m = |time_s: f64| {
            let place = ((time_s - plan.path.start_s) * rate).clamp(0.0, (raw.len() - 1) as f64);
            let before = place as usize;
            let after = (before + 1).min(raw.len() - 1);
            raw[before] + (raw[after] - raw[before]) * (place - before as f64)
        };
        let feet = (0..plan.path.n_samples())
            .map(|index| [0, 1].map(|side| foot_pose(plan, side, &body.sole, plan.path.time_s(index), &hips_m)))
            .collect();
        let wander = core::array::from_fn(|_| Wander::draw(draws));
        let breath = (draws.uniform(0.22, 0.3), draws.uniform(0.0, 1.0));
        let height_m = carriage.height_m.clone();
        let mut mover = Mover { plan, body, style, actions, carriage, feet, height_m, ground_m, wander, breath };
        mover.settle_height();
        mover
    }

    /// The posture at a sample of the path.
    pub(crate) fn posture(&self, index: usize) -> Posture {
        let mut local = [DQuat::IDENTITY; joint::COUNT];
        let pelvis = self.pelvis(index);
        let hips_m = self.hips_m(index, self.height_m[index]);
        let root_m = hips_m - pelvis * self.body.mid_hips_m;
        local[joint::ROOT] = pelvis;
        for side in 0..2 {
            let hip_m = root_m + pelvis * self.body.joints[joint::FEMUR[side]].offset_m;
            let turns = leg(self.body, side, pelvis, hip_m, &self.feet[index][side]);
            local[joint::FEMUR[side]] = turns.femur;
            local[joint::TIBIA[side]] = turns.tibia;
            local[joint::FOOT[side]] = turns.foot;
            local[joint::TOES[side]] = turns.toes;
            let pose = arm_pose(&self.carriage.flights, self.style, self.actions, side, &self.beat(index));
            for (joint, turn) in arm_turns(self.body, side, &pose) {
                local[joint] = turn;
            }
        }
        self.trunk(index, &mut local);
        Posture { root_m, local }
    }

    /// Lowers the hips to what the legs reach, and where the body is in flight moves them so that its centre of mass,
    /// not its pelvis, falls freely.
    fn settle_height(&mut self) {
        let n = self.height_m.len();
        for _ in 0..3 {
            let above_m: Vec<f64> = (0..n)
                .map(|index| {
                    if self.carriage.ballistic[index] < 1e-6 {
                        return 0.0;
                    }
                    let placed = self.body.place(&self.posture(index));
                    self.body.mass_center_m(&placed).y - self.height_m[index] - self.ground_m[index]
                })
                .collect();
            // The hips leave the ground at the height that was planned for them; constant during each flight.
            let mut takeoff_m = Knots::default();
            for flight in &self.carriage.flights {
                let above_m = above_m[self.plan.path.index(flight.takeoff_s)];
                takeoff_m.push(flight.takeoff_s, above_m);
                takeoff_m.push(flight.landing_s, above_m);
            }
            for (index, above_m) in above_m.iter().enumerate() {
                let wanted_m = takeoff_m.linear(self.plan.path.time_s(index));
                let corrected_m = self.carriage.ballistic[index] * (wanted_m - above_m);
                self.height_m[index] = self.carriage.height_m[index] + corrected_m;
            }
            self.keep_within_reach();
        }
    }

    fn keep_within_reach(&mut self) {
        let excess_m: Vec<f64> = (0..self.height_m.len())
            .map(|index| {
                let height_m = self.height_m[index];
                let pelvis = self.pelvis(index);
                let root_m = self.hips_m(index, height_m) - pelvis * self.body.mid_hips_m;
                let over = |side: usize| {
                    let hip_m = root_m + pelvis * self.body.joints[joint::FEMUR[side]].offset_m;
                    let ankle_m = self.feet[index][side].ankle_m;
                    highest_hip_m(self.body, hip_m, ankle_m, REACH).map_or(0.0, |highest_m| hip_m.y - highest_m)
                };
                over(0).max(over(1)).clamp(0.0, 0.3)
            })
            .collect();
        let lowered_m = gaussian(&running_max(&excess_m, 0.05), 0.02);
        for (height_m, lowered_m) in self.height_m.iter_mut().zip(&lowered_m) {
            *height_m -= lowered_m;
        }
    }

    fn beat(&self, index: usize) -> Beat {
        Beat {
            time_s: self.plan.path.time_s(index),
            walk: self.carriage.walk[index],
            run: self.carriage.run[index],
            stride: self.carriage.stride[index],
            speed_mps: self.plan.path.sample(index).pace_mps(),
            ahead: self.plan.path.sample(index).ahead(),
        }
    }

    /// How deep a jump's crouch is, share of the leg.
    fn crouch(&self, index: usize) -> f64 {
        let drop_m = self.carriage.stand_m - self.carriage.height_m[index];
        self.carriage.jump[index] * (drop_m / self.body.leg_m()).max(0.0)
    }

    /// Lean into a turn, radians, to the left.
    fn bank_rad(&self, index: usize) -> f64 {
        let point = self.plan.path.sample(index);
        0.7 * libm::atan(point.speed_mps * point.turn_rate_radps / GRAVITY_MPS2)
    }

    fn hips_m(&self, index: usize, height_m: f64) -> DVec3 {
        let point = self.plan.path.sample(index);
        let time_s = self.plan.path.time_s(index);
        let still = self.still(index);
        let left_m = self.carriage.sway_m[index]
            + libm::tan(self.bank_rad(index)) * 0.8 * height_m
            + still * 0.008 * self.wander[0].at(time_s);
        let ahead_m =
            still * (0.025 + 0.010 * self.wander[1].at(time_s)) - 0.42 * self.crouch(index) * self.body.leg_m();
        let (sin, cos) = libm::sincos(point.yaw_rad);
        DVec3::new(
            point.x_m + cos * left_m + sin * ahead_m,
            height_m + self.ground_m[index],
            point.z_m - sin * left_m + cos * ahead_m,
        )
    }

    /// How much of a stand.
    fn still(&self, index: usize) -> f64 {
        (1.0 - self.carriage.walk[index] - self.carriage.run[index] - self.carriage.jump[index]).clamp(0.0, 1.0)
    }

    /// Turn to the left and roll (left side up) of the pelvis that go with the steps, radians.
    fn pelvis_swing_rad(&self, index: usize) -> (f64, f64) {
        let Carriage { walk, run, stride, .. } = &self.carriage;
        let (sin, cos) = libm::sincos(TAU * stride[index]);
        let point = self.plan.path.sample(index);
        let speed_mps = point.pace_mps().min(3.0);
        let turn = self.style.twist * (walk[index] * (0.03 + 0.045 * speed_mps) + run[index] * 0.10);
        let roll = self.style.bounce * (walk[index] * (0.015 + 0.025 * speed_mps) + run[index] * 0.06);
        (-turn * cos * point.ahead(), roll * sin)
    }

    /// Forward tilt of the pelvis and of the chest, radians.
    fn tilt_rad(&self, index: usize) -> (f64, f64) {
        let Carriage { walk, run, stride, .. } = &self.carriage;
        let speed_mps = self.plan.path.sample(index).pace_mps();
        let nod = libm::cos(2.0 * TAU * (stride[index] - 0.05));
        let lean = 0.02 + self.style.lean_rad + 0.02 * walk[index] + run[index] * (0.07 + 0.012 * speed_mps);
        let nodding = nod * (0.012 * walk[index] + 0.02 * run[index]);
        let crouch = self.crouch(index);
        (0.5 * lean + 1.3 * crouch, lean + nodding + 2.3 * crouch)
    }

    fn pelvis(&self, index: usize) -> DQuat {
        let (turn, roll) = self.pelvis_swing_rad(index);
        let (tilt, _) = self.tilt_rad(index);
        let yaw = self.plan.path.sample(index).yaw_rad + turn;
        about(Axis::Y, yaw) * about(Axis::X, tilt) * about(Axis::Z, roll - self.bank_rad(index))
    }

    /// Spine, neck and head: the chest turns against the pelvis, the head looks ahead.
    fn trunk(&self, index: usize, local: &mut [DQuat; joint::COUNT]) {
        let time_s = self.plan.path.time_s(index);
        let Carriage { walk, run, stride, .. } = &self.carriage;
        let point = self.plan.path.sample(index);
        let speed_mps = point.pace_mps().min(2.0);
        let still = self.still(index);
        let (pelvis_turn, pelvis_roll) = self.pelvis_swing_rad(index);
        let (pelvis_tilt, chest_tilt) = self.tilt_rad(index);
        let swing = self.style.twist * (walk[index] * (0.02 + 0.04 * speed_mps) + run[index] * 0.16);
        let chest_turn =
            point.ahead() * swing * libm::cos(TAU * (stride[index] + 0.05)) + still * 0.02 * self.wander[2].at(time_s);
        let breath = libm::sin(TAU * (self.breath.0 * time_s + self.breath.1));
        let chest_tilt = chest_tilt - 0.006 * breath;
        let third = |turn: f64, tilt: f64, roll: f64| {
            about(Axis::Y, turn / 3.0) * about(Axis::X, tilt / 3.0) * about(Axis::Z, roll / 3.0)
        };
        let spine = third(chest_turn - pelvis_turn, chest_tilt - pelvis_tilt, -0.85 * pelvis_roll);
        for joint in [joint::LOWER_BACK, joint::UPPER_BACK, joint::THORAX] {
            local[joint] = spine;
        }
        let ahead = 0.25 * self.plan.path.sample(index).turn_rate_radps;
        let gaze = ahead + 0.10 * (0.4 + 0.6 * still) * self.wander[3].at(time_s);
        let nod = self.style.head_rad + 0.03 * self.wander[1].at(0.7 * time_s + 3.0);
        let neck = third(gaze - chest_turn, nod - 0.75 * chest_tilt, 0.6 * self.bank_rad(index));
        for joint in [joint::LOWER_NECK, joint::UPPER_NECK, joint::HEAD] {
            local[joint] = neck;
        }
    }
}

impl Wander {
    fn draw(draws: &mut Draws) -> Wander {
        Wander { waves: [0.11, 0.19, 0.37].map(|hz| (hz * draws.uniform(0.8, 1.25), draws.uniform(0.0, 1.0))) }
    }

    fn at(&self, time_s: f64) -> f64 {
        let parts = self.waves.map(|(hz, phase)| libm::sin(TAU * (hz * time_s + phase)));
        0.5 * parts[0] + 0.35 * parts[1] + 0.15 * parts[2]
    }
}
