//! What capture does to a motion: noise, drop-outs, spikes, and floors that are not where they should be.

use super::draws::Draws;
use crate::motion::rotation::about;
use crate::motion::{Axis, Poses};
use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

/// One disturbance of joint positions (CONTACTS 5 and 6 list those that labels should bear).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Disturbance {
    /// Normal noise, fresh in every frame, in every coordinate of every point.
    White {
        /// Standard deviation of a coordinate, metres, 0 to 1.
        sd_m: f64,
    },
    /// Normal noise that wanders: a first-order process, in every coordinate of every point.
    Correlated {
        /// Standard deviation of a coordinate, metres, 0 to 1.
        sd_m: f64,
        /// Time after which the correlation has fallen to 1/e, seconds, 0.001 to 10.
        correlation_s: f64,
    },
    /// A point stays where it was for some frames, at irregular times, each point at its own.
    Dropouts {
        /// Frames that repeat the one before them, 1 to 1000.
        frames: u32,
        /// Mean time from one drop-out of a point to its next, seconds, 0.1 to 3600.
        every_s: f64,
    },
    /// A point is elsewhere for a moment, in any direction, at irregular times, each point at its own.
    Spikes {
        /// How far, metres, 0 to 10.
        size_m: f64,
        /// How long, seconds, 0.001 to 10: at least a frame.
        seconds: f64,
        /// Mean time from one spike of a point to its next, seconds, 0.1 to 3600.
        every_s: f64,
    },
    /// Everything is higher.
    Offset {
        /// How much, metres, -100 to 100.
        up_m: f64,
    },
    /// The world is turned about a horizontal axis through the origin.
    Tilt {
        /// How much, radians, -0.5 to 0.5.
        tilt_rad: f64,
        /// Heading of the axis, from +Z towards +X, radians.
        axis_yaw_rad: f64,
    },
}

/// A disturbance that has no meaning.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{what} is {found}, must lie in {low} to {high}")]
pub struct DisturbError {
    /// Which value.
    pub what: &'static str,
    /// As given.
    pub found: f64,
    /// Least.
    pub low: f64,
    /// Most.
    pub high: f64,
}

impl Disturbance {
    /// The numbers of CONTACTS 5: 10 cm away for 0.1 s, every 2 s.
    pub const SPIKES: Disturbance = Disturbance::Spikes { size_m: 0.1, seconds: 0.1, every_s: 2.0 };

    /// Whether every value lies in its range.
    ///
    /// # Errors
    /// [`DisturbError`] names the first that does not.
    pub fn check(&self) -> Result<(), DisturbError> {
        let within = |what, found: f64, low: f64, high: f64| {
            if low <= found && found <= high { Ok(()) } else { Err(DisturbError { what, found, low, high }) }
        };
        match *self {
            Disturbance::White { sd_m } => within("sd_m", sd_m, 0.0, 1.0),
            Disturbance::Correlated { sd_m, correlation_s } => {
                within("sd_m", sd_m, 0.0, 1.0)?;
                within("correlation_s", correlation_s, 0.001, 10.0)
            }
            Disturbance::Dropouts { frames, every_s } => {
                within("frames", f64::from(frames), 1.0, 1000.0)?;
                within("every_s", every_s, 0.1, 3600.0)
            }
            Disturbance::Spikes { size_m, seconds, every_s } => {
                within("size_m", size_m, 0.0, 10.0)?;
                within("seconds", seconds, 0.001, 10.0)?;
                within("every_s", every_s, 0.1, 3600.0)
            }
            Disturbance::Offset { up_m } => within("up_m", up_m, -100.0, 100.0),
            Disturbance::Tilt { tilt_rad, axis_yaw_rad } => {
                within("tilt_rad", tilt_rad, -0.5, 0.5)?;
                within("axis_yaw_rad", axis_yaw_rad, -1e3, 1e3)
            }
        }
    }
}

/// Disturbs the positions of a clip; several disturbances are several calls.
///
/// # Shapes and units
/// Positions in metres, world, Y up, `rate_hz` frames a second; the answer has the shape of `poses`. The ends of
/// bones are disturbed like joints. Pure: draws are taken point by point, so the same stream gives the same bits.
///
/// A disturbance that [`Disturbance::check`] refuses gives positions without meaning, never a panic.
///
/// # Source
/// CONTACTS 5 (invariances) and 6 (generator).
pub fn disturb(poses: &Poses, rate_hz: f64, disturbance: &Disturbance, draws: &mut Draws) -> Poses {
    let mut disturbed = poses.clone();
    let n = poses.n_points;
    match *disturbance {
        Disturbance::White { sd_m } => {
            for point in 0..n {
                for at in disturbed.world.iter_mut().skip(point).step_by(n) {
                    *at += sd_m * normal(draws);
                }
            }
        }
        Disturbance::Correlated { sd_m, correlation_s } => {
            let kept = libm::exp(-1.0 / (rate_hz * correlation_s));
            let fresh = libm::sqrt(1.0 - kept * kept);
            for point in 0..n {
                // As likely in the first frame as in any other.
                let mut wander = normal(draws);
                for at in disturbed.world.iter_mut().skip(point).step_by(n) {
                    *at += sd_m * wander;
                    wander = kept * wander + fresh * normal(draws);
                }
            }
        }
        Disturbance::Dropouts { frames, every_s } => {
            for point in 0..n {
                for (start, end) in moments(poses.n_frames, frames as usize, rate_hz * every_s, draws) {
                    // A clip's first frame has nothing before it.
                    let held = poses.at(start.saturating_sub(1), point);
                    for frame in start..end {
                        disturbed.world[frame * n + point] = held;
                    }
                }
            }
        }
        Disturbance::Spikes { size_m, seconds, every_s } => {
            let frames = (seconds * rate_hz).round().max(1.0) as usize;
            for point in 0..n {
                for (start, end) in moments(poses.n_frames, frames, rate_hz * every_s, draws) {
                    let away = size_m * normal(draws).normalize_or(DVec3::X);
                    for frame in start..end {
                        disturbed.world[frame * n + point] += away;
                    }
                }
            }
        }
        Disturbance::Offset { up_m } => disturbed.world.iter_mut().for_each(|at| at.y += up_m),
        Disturbance::Tilt { tilt_rad, axis_yaw_rad } => {
            let turn: DQuat = about(Axis::Y, axis_yaw_rad) * about(Axis::Z, tilt_rad) * about(Axis::Y, -axis_yaw_rad);
            disturbed.world.iter_mut().for_each(|at| *at = turn * *at);
        }
    }
    disturbed
}

fn normal(draws: &mut Draws) -> DVec3 {
    let [x, y, z] = core::array::from_fn(|_| draws.normal());
    DVec3::new(x, y, z)
}

/// Half-open runs of `length` frames that begin, on the average, every `mean` frames and never touch: from one start
/// to the next half to one and a half of that.
fn moments(n_frames: usize, length: usize, mean: f64, draws: &mut Draws) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut start = (mean * draws.uniform(0.0, 1.0)) as usize;
    while start < n_frames {
        found.push((start, start.saturating_add(length).min(n_frames)));
        let next = (mean * draws.uniform(0.5, 1.5)) as usize;
        start = start.saturating_add(next.max(length.saturating_add(1)));
    }
    found
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;

    /// Two points a metre apart on a way along +Z.
    fn still(n_frames: usize) -> Poses {
        let world = (0..2 * n_frames).map(|k| DVec3::new((k % 2) as f64, 1.0, 0.01 * (k / 2) as f64)).collect();
        Poses { n_frames, n_points: 2, world }
    }

    fn disturbed(n_frames: usize, disturbance: Disturbance) -> (Poses, Vec<DVec3>) {
        disturbance.check().unwrap();
        let poses = still(n_frames);
        let made = disturb(&poses, 100.0, &disturbance, &mut Draws::new(5, "clip", "noise"));
        let away = made.world.iter().zip(&poses.world).map(|(a, b)| *a - *b).collect();
        (made, away)
    }

    fn mean(values: impl Iterator<Item = f64>) -> f64 {
        let values: Vec<f64> = values.collect();
        values.iter().sum::<f64>() / values.len() as f64
    }

    #[test]
    fn noise_has_its_deviation_and_its_memory() {
        let (_, away) = disturbed(20_000, Disturbance::White { sd_m: 0.005 });
        for axis in 0..3 {
            let sd_m = libm::sqrt(mean(away.iter().map(|d| d[axis] * d[axis])));
            assert!((sd_m / 0.005 - 1.0).abs() < 0.02, "{sd_m}");
            let next = mean((2..away.len()).map(|k| away[k][axis] * away[k - 2][axis])) / (sd_m * sd_m);
            let other = mean((0..20_000).map(|k| away[2 * k][axis] * away[2 * k + 1][axis])) / (sd_m * sd_m);
            assert!(next.abs() < 0.03 && other.abs() < 0.03, "{next} {other}");
        }
        let (_, away) = disturbed(60_000, Disturbance::Correlated { sd_m: 0.01, correlation_s: 0.05 });
        let sd_m = libm::sqrt(mean(away.iter().map(|d| d.y * d.y)));
        assert!((sd_m / 0.01 - 1.0).abs() < 0.05, "{sd_m}");
        // Five frames of a hundredth of a second.
        let later = mean((10..away.len()).map(|k| away[k].y * away[k - 10].y)) / (sd_m * sd_m);
        assert!((later - libm::exp(-1.0)).abs() < 0.04, "{later}");
        let other = mean((0..60_000).map(|k| away[2 * k].y * away[2 * k + 1].y)) / (sd_m * sd_m);
        assert!(other.abs() < 0.06, "{other}");
    }

    #[test]
    fn spikes_are_as_far_as_long_and_as_many_as_asked_for() {
        let (_, away) = disturbed(60_000, Disturbance::SPIKES);
        for point in 0..2 {
            let path: Vec<DVec3> = away.iter().skip(point).step_by(2).copied().collect();
            let starts: Vec<usize> =
                (1..path.len()).filter(|&k| path[k].length() > 0.0 && path[k - 1].length() == 0.0).collect();
            assert!((280..=320).contains(&starts.len()), "{} in ten minutes", starts.len());
            for &start in starts.iter().filter(|&&start| start + 11 < path.len()) {
                assert!((start..start + 10).all(|k| (path[k].length() - 0.1).abs() < 1e-9));
                assert!(path[start + 10].length() == 0.0, "a tenth of a second");
            }
        }
        let both = away.chunks(2).filter(|pair| pair[0].length() > 0.0 && pair[1].length() > 0.0).count();
        assert!(both < 600, "each point has its own times: {both}");
    }

    #[test]
    fn a_dropped_point_stays_where_it_was() {
        let (made, away) = disturbed(20_000, Disturbance::Dropouts { frames: 8, every_s: 1.0 });
        let path = made.path(0);
        let frozen = (1..path.len()).filter(|&k| path[k] == path[k - 1]).count();
        let lost = away.iter().step_by(2).filter(|d| d.length() > 0.0).count();
        assert_eq!(frozen, lost);
        assert!((1400..=1800).contains(&frozen), "{frozen} frames of 20000, 8 a second");
        let longest = (0..path.len() - 9).find(|&k| (k..k + 9).all(|k| path[k] == path[k + 1]));
        assert_eq!(longest, None, "eight frames, not nine");
    }

    #[test]
    fn floors_move_exactly() {
        let (_, away) = disturbed(10, Disturbance::Offset { up_m: -1.25 });
        assert!(away.iter().all(|d| *d == DVec3::new(0.0, -1.25, 0.0)));
        // About +X: what is ahead goes down or up with the sine.
        let (made, _) = disturbed(101, Disturbance::Tilt { tilt_rad: 0.1, axis_yaw_rad: core::f64::consts::FRAC_PI_2 });
        let ahead = made.at(100, 0) - made.at(0, 0);
        assert!((ahead.length() - 1.0).abs() < 1e-6, "{ahead}");
        assert!((ahead.y.abs() - libm::sin(0.1)).abs() < 1e-6 && ahead.x.abs() < 1e-6, "{ahead}");
        let across = made.at(0, 1) - made.at(0, 0);
        assert!((across - DVec3::X).length() < 1e-6, "the axis stays level: {across}");
    }

    #[test]
    fn the_same_stream_gives_the_same_bits_on_every_machine() {
        let mut hasher = blake3::Hasher::new();
        for disturbance in [
            Disturbance::White { sd_m: 0.005 },
            Disturbance::Correlated { sd_m: 0.01, correlation_s: 0.025 },
            Disturbance::Dropouts { frames: 5, every_s: 0.5 },
            Disturbance::SPIKES,
            Disturbance::Tilt { tilt_rad: 0.035, axis_yaw_rad: 1.0 },
        ] {
            let (made, _) = disturbed(500, disturbance);
            assert_eq!(made, disturbed(500, disturbance).0);
            for at in &made.world {
                at.to_array().iter().for_each(|value| {
                    hasher.update(&value.to_le_bytes());
                });
            }
        }
        assert_eq!(
            hasher.finalize().to_hex().as_str(),
            "1cc204e84f8bd51c9fc553b3060ab71fd168ced536a4fdfe2a6d86a2f3297f53"
        );
    }

    #[test]
    fn what_has_no_meaning_is_refused_and_never_panics() {
        for wrong in [
            Disturbance::White { sd_m: f64::NAN },
            Disturbance::Correlated { sd_m: 0.01, correlation_s: 0.0 },
            Disturbance::Dropouts { frames: 0, every_s: -1.0 },
            Disturbance::Spikes { size_m: 0.1, seconds: f64::INFINITY, every_s: f64::NAN },
            Disturbance::Offset { up_m: f64::INFINITY },
            Disturbance::Tilt { tilt_rad: 2.0, axis_yaw_rad: 0.0 },
        ] {
            assert!(wrong.check().is_err(), "{wrong:?}");
            for rate_hz in [0.0, f64::NAN, 1e300] {
                let made = disturb(&still(20), rate_hz, &wrong, &mut Draws::new(1, "x", "y"));
                assert_eq!(made.world.len(), 40);
            }
        }
        let none = Poses { n_frames: 0, n_points: 0, world: Vec::new() };
        for fine in [Disturbance::White { sd_m: 0.1 }, Disturbance::SPIKES] {
            assert_eq!(disturb(&none, 30.0, &fine, &mut Draws::new(1, "x", "y")), none);
        }
    }
}
