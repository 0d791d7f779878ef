//! Rotations about axes, and back to angles: the same bits on every machine (transcendentals from `libm`).

use super::skeleton::Axis;
use glam::{DQuat, DVec3};

/// A rotation about one axis.
pub fn about(axis: Axis, angle_rad: f64) -> DQuat {
    let (sin, cos) = libm::sincos(angle_rad * 0.5);
    let mut parts = [0.0; 3];
    parts[axis.index()] = sin;
    DQuat::from_xyzw(parts[0], parts[1], parts[2], cos)
}

/// Angles (radians) of `Ra(angles[0]) Rb(angles[1]) Rc(angles[2])` that give `rotation`, for three different axes.
///
/// The middle angle lies in [-pi/2, pi/2]. At gimbal lock the last angle is 0.
pub fn euler(rotation: DQuat, order: [Axis; 3]) -> [f64; 3] {
    let [i, j, k] = order.map(Axis::index);
    debug_assert!(i != j && j != k && i != k, "three different axes");
    // Columns of the matrix are the images of the axes: m(row, column).
    let columns = [rotation * DVec3::X, rotation * DVec3::Y, rotation * DVec3::Z];
    let m = |row: usize, column: usize| columns[column][row];
    // +1 for cyclic orders (XYZ, YZX, ZXY), -1 for the others.
    let sign = if (i + 1) % 3 == j { 1.0 } else { -1.0 };
    let sin_middle = (sign * m(i, k)).clamp(-1.0, 1.0);
    let middle = libm::asin(sin_middle);
    if sin_middle.abs() > 1.0 - 1e-12 {
        return [libm::atan2(sign * m(k, j), m(j, j)), middle, 0.0];
    }
    [libm::atan2(-sign * m(j, k), m(k, k)), middle, libm::atan2(-sign * m(i, j), m(i, i))]
}

/// The angle equal to `angle` modulo `turn` (360 or 2 pi) that lies nearest to `previous`.
pub fn unwrap(angle: f64, previous: f64, turn: f64) -> f64 {
    angle - ((angle - previous) / turn).round() * turn
}

/// Of the two ways to write a rotation as three angles about different axes, the one nearest to `previous`,
/// each angle unwrapped; radians.
pub fn euler_near(rotation: DQuat, order: [Axis; 3], previous: [f64; 3]) -> [f64; 3] {
    use core::f64::consts::{PI, TAU};
    let first = euler(rotation, order);
    let second = [first[0] + PI, PI - first[1], first[2] + PI];
    let near = |angles: [f64; 3]| core::array::from_fn(|n| unwrap(angles[n], previous[n], TAU));
    let far = |angles: [f64; 3]| (0..3).map(|n| (angles[n] - previous[n]).abs()).sum::<f64>();
    let (first, second) = (near(first), near(second));
    if far(second) < far(first) { second } else { first }
}

/// Axis times angle, the short way round.
pub fn rotation_vector(rotation: DQuat) -> DVec3 {
    let rotation = if rotation.w < 0.0 { -rotation } else { rotation };
    let part = DVec3::new(rotation.x, rotation.y, rotation.z);
    let norm = part.length();
    if norm > 1e-9 { part / norm * (2.0 * libm::atan2(norm, rotation.w)) } else { part * 2.0 }
}

/// Spherical interpolation, `b` brought to `a`'s hemisphere first.
pub fn slerp(a: DQuat, b: DQuat, t: f64) -> DQuat {
    let dot = a.dot(b);
    let b = if dot < 0.0 { -b } else { b };
    let angle = libm::acos(dot.abs().min(1.0));
    let sin = libm::sin(angle);
    let (wa, wb) =
        if sin > 1e-6 { (libm::sin((1.0 - t) * angle) / sin, libm::sin(t * angle) / sin) } else { (1.0 - t, t) };
    (a * wa + b * wb).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    const ORDERS: [[Axis; 3]; 6] = [
        [Axis::X, Axis::Y, Axis::Z],
        [Axis::Y, Axis::Z, Axis::X],
        [Axis::Z, Axis::X, Axis::Y],
        [Axis::X, Axis::Z, Axis::Y],
        [Axis::Y, Axis::X, Axis::Z],
        [Axis::Z, Axis::Y, Axis::X],
    ];

    #[test]
    fn euler_angles_rebuild_the_rotation_in_every_order() {
        for order in ORDERS {
            for angles in
                [[0.3, -0.7, 1.9], [-2.5, 1.4, 0.1], [3.0, -1.5, -3.0], [0.4, core::f64::consts::FRAC_PI_2, 0.2]]
            {
                let build = |a: [f64; 3]| about(order[0], a[0]) * about(order[1], a[1]) * about(order[2], a[2]);
                let rotation = build(angles);
                assert!(build(euler(rotation, order)).dot(rotation).abs() > 1.0 - 1e-12, "{order:?} {angles:?}");
                let near = euler_near(rotation, order, angles);
                assert!(build(near).dot(rotation).abs() > 1.0 - 1e-12, "{order:?} {angles:?}");
            }
        }
    }

    #[test]
    fn euler_near_follows_a_turn_past_the_lock() {
        let order = [Axis::Z, Axis::X, Axis::Y];
        let mut previous = [0.0; 3];
        for step in 0..100 {
            let wanted = [0.2, 0.04 * f64::from(step), 0.1];
            let rotation = about(order[0], wanted[0]) * about(order[1], wanted[1]) * about(order[2], wanted[2]);
            previous = euler_near(rotation, order, previous);
            assert!((0..3).all(|n| (previous[n] - wanted[n]).abs() < 1e-6), "{step} {previous:?}");
        }
    }
}
