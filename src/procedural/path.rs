//! The body's way over the ground: speed and turning as smooth functions of time, integrated once.

/// Samples of the way and of everything that follows it, a second: every frame rate that divides it reads samples as they are.
pub(super) const GRID_HZ: u32 = 240;

/// Values at times, joined smoothly: constant before the first and after the last.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Knots {
    /// (seconds, value), times never going back.
    knots: Vec<(f64, f64)>,
}

/// A point of the way.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Waypoint {
    /// World metres.
    pub x_m: f64,
    /// World metres.
    pub z_m: f64,
    /// Radians from +Z towards +X, not wrapped.
    pub yaw_rad: f64,
    /// m/s along the heading; negative when the body goes backwards.
    pub speed_mps: f64,
    /// rad/s, to the left.
    pub turn_rate_radps: f64,
    /// m/s to the left of the heading.
    pub aside_mps: f64,
    /// Rise of a slope above the ground at time 0, metres (stairs are not in it).
    pub rise_m: f64,
    /// Rise over run of the ground along the heading.
    pub grade: f64,
}

/// What the way is integrated from, each over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Course {
    /// Along the heading, m/s.
    pub speed: Knots,
    /// To the left of the heading, m/s.
    pub aside: Knots,
    /// Of the heading, to the left, rad/s.
    pub turn: Knots,
    /// Rise over run of the ground along the heading.
    pub grade: Knots,
}

/// The way, sampled 240 times a second; it passes the origin at time 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// Time of the first sample.
    pub start_s: f64,
    points: Vec<Waypoint>,
}

impl Knots {
    /// Appends a value; a time before the last one's is moved to it.
    pub fn push(&mut self, time_s: f64, value: f64) {
        let time_s = self.knots.last().map_or(time_s, |last| time_s.max(last.0));
        self.knots.push((time_s, value));
    }

    /// Holds the last value until `start_s`, then goes to `value` at `end_s`.
    pub fn ramp(&mut self, start_s: f64, end_s: f64, value: f64) {
        let held = self.knots.last().map_or(value, |last| last.1);
        self.push(start_s, held);
        self.push(end_s, value);
    }

    /// Between two knots: the smooth step 3 u^2 - 2 u^3 from one value to the next.
    pub fn smooth(&self, time_s: f64) -> f64 {
        self.between(time_s, |u| u * u * (3.0 - 2.0 * u))
    }

    /// Between two knots: the straight line; beyond the ends, their values.
    pub fn linear(&self, time_s: f64) -> f64 {
        self.between(time_s, |u| u)
    }

    fn between(&self, time_s: f64, ease: impl Fn(f64) -> f64) -> f64 {
        let after = self.knots.partition_point(|knot| knot.0 <= time_s);
        match (after.checked_sub(1).map(|before| self.knots[before]), self.knots.get(after)) {
            (Some((t0, v0)), Some(&(t1, v1))) => v0 + (v1 - v0) * ease((time_s - t0) / (t1 - t0)),
            (Some((_, value)), None) | (None, Some(&(_, value))) => value,
            (None, None) => 0.0,
        }
    }
}

impl Waypoint {
    /// Speed in whatever direction, m/s: bodies go along or across their heading, not both.
    pub(super) fn pace_mps(&self) -> f64 {
        self.speed_mps.abs() + self.aside_mps.abs()
    }

    /// 1 for a body that goes forward or stands, -1 for one that goes backwards, smooth between: what swings with the
    /// legs swings the other way.
    pub(super) fn ahead(&self) -> f64 {
        if self.speed_mps < 0.0 { (1.0 + 8.0 * self.speed_mps).max(-1.0) } else { 1.0 }
    }
}

impl Path {
    /// Integrates a course over `[start_s, end_s]`, start rounded down to the grid; at time 0 the way is at
    /// the origin with heading `yaw_rad`.
    pub fn new(start_s: f64, end_s: f64, yaw_rad: f64, course: &Course) -> Path {
        let rate = f64::from(GRID_HZ);
        let first = (start_s.min(0.0) * rate).floor() as i64;
        let last = (end_s.max(0.0) * rate).ceil() as i64;
        let mut points = vec![Waypoint::default(); (last - first + 1) as usize];
        let zero = (-first) as usize;
        let rates = |index: usize| {
            let time_s = (first + index as i64) as f64 / rate;
            Waypoint {
                speed_mps: course.speed.smooth(time_s),
                aside_mps: course.aside.smooth(time_s),
                turn_rate_radps: course.turn.smooth(time_s),
                grade: course.grade.smooth(time_s),
                ..Waypoint::default()
            }
        };
        // Midpoint of the heading over each interval, forwards and backwards from time 0.
        let advance = |from: Waypoint, sign: f64, to: usize| {
            let here = rates(to);
            let turned = 0.5 * (from.turn_rate_radps + here.turn_rate_radps) / rate * sign;
            let (sin, cos) = libm::sincos(from.yaw_rad + 0.5 * turned);
            let gone = 0.5 * (from.speed_mps + here.speed_mps) / rate * sign;
            let aside = 0.5 * (from.aside_mps + here.aside_mps) / rate * sign;
            Waypoint {
                x_m: from.x_m + sin * gone + cos * aside,
                z_m: from.z_m + cos * gone - sin * aside,
                yaw_rad: from.yaw_rad + turned,
                rise_m: from.rise_m + 0.5 * (from.grade + here.grade) * gone,
                ..here
            }
        };
        points[zero] = Waypoint { yaw_rad, ..rates(zero) };
        for to in zero + 1..points.len() {
            points[to] = advance(points[to - 1], 1.0, to);
        }
        for to in (0..zero).rev() {
            points[to] = advance(points[to + 1], -1.0, to);
        }
        Path { start_s: first as f64 / rate, points }
    }

    /// Number of samples.
    pub fn n_samples(&self) -> usize {
        self.points.len()
    }

    /// Time of a sample.
    pub fn time_s(&self, index: usize) -> f64 {
        // Whole samples first, so that equal times are equal bits.
        let first = (self.start_s * f64::from(GRID_HZ)).round();
        (first + index as f64) / f64::from(GRID_HZ)
    }

    /// The sample at a time on the grid, clamped to the ends.
    pub fn index(&self, time_s: f64) -> usize {
        let index = ((time_s - self.start_s) * f64::from(GRID_HZ)).round();
        (index.max(0.0) as usize).min(self.points.len() - 1)
    }

    /// A sample.
    pub fn sample(&self, index: usize) -> Waypoint {
        self.points[index]
    }

    /// The way at any time, straight lines between samples, clamped to the ends.
    pub fn at(&self, time_s: f64) -> Waypoint {
        let place = ((time_s - self.start_s) * f64::from(GRID_HZ)).max(0.0);
        let before = (place as usize).min(self.points.len() - 1);
        let after = (before + 1).min(self.points.len() - 1);
        let u = (place - before as f64).min(1.0);
        let (a, b) = (self.points[before], self.points[after]);
        let mix = |a: f64, b: f64| a + (b - a) * u;
        Waypoint {
            x_m: mix(a.x_m, b.x_m),
            z_m: mix(a.z_m, b.z_m),
            yaw_rad: mix(a.yaw_rad, b.yaw_rad),
            speed_mps: mix(a.speed_mps, b.speed_mps),
            turn_rate_radps: mix(a.turn_rate_radps, b.turn_rate_radps),
            aside_mps: mix(a.aside_mps, b.aside_mps),
            rise_m: mix(a.rise_m, b.rise_m),
            grade: mix(a.grade, b.grade),
        }
    }
}

/// Weighted mean of a track's neighborhood by a Gaussian of `sigma_s`, cut at three; the ends repeated.
pub(crate) fn gaussian(track: &[f64], sigma_s: f64) -> Vec<f64> {
    let sigma = sigma_s * f64::from(GRID_HZ);
    let reach = (3.0 * sigma).ceil() as usize;
    let weights: Vec<f64> = (0..=reach).map(|k| libm::exp(-0.5 * (k as f64 / sigma) * (k as f64 / sigma))).collect();
    let total = weights[0] + 2.0 * weights[1..].iter().sum::<f64>();
    let last = track.len().saturating_sub(1);
    (0..track.len())
        .map(|at| {
            let sum = (1..=reach).fold(weights[0] * track[at], |sum, k| {
                sum + weights[k] * (track[at.saturating_sub(k)] + track[(at + k).min(last)])
            });
            sum / total
        })
        .collect()
}

/// Largest value within `reach_s` on either side.
pub(crate) fn running_max(track: &[f64], reach_s: f64) -> Vec<f64> {
    let reach = (reach_s * f64::from(GRID_HZ)).round() as usize;
    (0..track.len())
        .map(|at| {
            let near = &track[at.saturating_sub(reach)..(at + reach + 1).min(track.len())];
            near.iter().copied().fold(f64::NEG_INFINITY, f64::max)
        })
        .collect()
}

/// 0 before 0, 1 after 1, 3 u^2 - 2 u^3 between.
pub(crate) fn smoothstep(u: f64) -> f64 {
    let u = u.clamp(0.0, 1.0);
    u * u * (3.0 - 2.0 * u)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_steady_turn_closes_its_circle() {
        let mut course = Course::default();
        course.speed.push(0.0, 1.0);
        course.turn.push(0.0, core::f64::consts::TAU / 10.0);
        let path = Path::new(-1.0, 10.0, 0.3, &course);
        let (start, end) = (path.at(0.0), path.at(10.0));
        assert!((end.x_m - start.x_m).abs() < 1e-9 && (end.z_m - start.z_m).abs() < 1e-9);
        assert!((end.yaw_rad - start.yaw_rad - core::f64::consts::TAU).abs() < 1e-9);
        assert!(path.at(0.1).x_m > 0.0 && path.at(0.1).z_m > 0.0, "heading 0.3 leads towards +Z and a little +X");
    }

    #[test]
    fn backwards_sideways_and_uphill_are_what_they_say() {
        let mut course = Course::default();
        course.speed.push(0.0, -0.5);
        course.aside.push(0.0, 0.25);
        course.grade.push(0.0, 0.1);
        let end = Path::new(-1.0, 4.0, 0.0, &course).at(4.0);
        assert!((end.z_m + 2.0).abs() < 1e-9 && (end.x_m - 1.0).abs() < 1e-9, "{end:?}");
        assert!((end.rise_m + 0.2).abs() < 1e-9, "backwards down a rise: {end:?}");
        assert_eq!((end.ahead(), end.pace_mps()), (-1.0, 0.75));
    }

    #[test]
    fn ramps_hold_and_rise() {
        let mut knots = Knots::default();
        knots.push(-1.0, 0.0);
        knots.ramp(1.0, 2.0, 3.0);
        knots.ramp(1.5, 2.5, 1.0);
        assert_eq!([-2.0, 0.9, 1.5, 2.0, 2.5, 9.0].map(|t| knots.smooth(t)), [0.0, 0.0, 1.5, 3.0, 1.0, 1.0]);
    }

    #[test]
    fn smoothing_keeps_constants_and_lowers_peaks() {
        assert!(gaussian(&[2.0; 50], 0.02).iter().all(|v| (v - 2.0).abs() < 1e-12));
        let mut spike = vec![0.0; 101];
        spike[50] = 1.0;
        let smooth = gaussian(&spike, 0.01);
        assert!(smooth[50] < 0.5 && (smooth.iter().sum::<f64>() - 1.0).abs() < 1e-9);
        let wide = running_max(&spike, 2.0 / 240.0);
        assert_eq!(wide.iter().filter(|v| **v == 1.0).count(), 5);
    }
}
