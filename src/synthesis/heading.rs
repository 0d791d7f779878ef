//! Where the body faces, smoothed: the normal of the hip line on the ground plane, low-passed (GRAFTS 2).

use super::signal::lowpass_points;
use super::subject::Movement;
use glam::DVec3;

const CUTOFF_HZ: f64 = 0.7;
/// Clips of up to this many frames get one heading, their mean.
const SHORT_FRAMES: usize = 30;
/// A hip line with a shorter horizontal part than this has no normal.
const MIN_HIP_WIDTH_M: f64 = 1e-6;

/// Forward on the ground plane, `[frame]`, unit length; zero only where no frame of the clip has a heading.
///
/// Where the hips lie one above the other the last heading is carried on. Left is `Y x forward`.
pub fn forward(movement: &Movement) -> Vec<DVec3> {
    let [left, right] = movement.landmarks.legs.map(|leg| leg.thigh);
    let mut normals: Vec<Option<DVec3>> = movement
        .path_from(left, right)
        .into_iter()
        .map(|line| DVec3::new(line.x, 0.0, line.z))
        .map(|line| (line.length() > MIN_HIP_WIDTH_M).then(|| (line / line.length()).cross(DVec3::Y)))
        .collect();
    let mut last = normals.iter().copied().flatten().next().unwrap_or(DVec3::ZERO);
    for normal in &mut normals {
        last = *normal.get_or_insert(last);
    }
    let normals: Vec<DVec3> = normals.into_iter().flatten().collect();
    let smooth = if normals.len() > SHORT_FRAMES {
        lowpass_points(&normals, CUTOFF_HZ, movement.rate_hz)
    } else {
        vec![normals.iter().sum::<DVec3>() / normals.len().max(1) as f64; normals.len()]
    };
    smooth.into_iter().map(|normal| DVec3::new(normal.x, 0.0, normal.z).normalize_or_zero()).collect()
}

/// How far the left one of two points is ahead of the right one along `forward`, `[frame]`, metres.
pub fn left_ahead(movement: &Movement, points: [usize; 2], forward: &[DVec3]) -> Vec<f64> {
    movement.path_from(points[0], points[1]).iter().zip(forward).map(|(offset, forward)| offset.dot(*forward)).collect()
}

#[cfg(test)]
mod tests {
    use super::super::walker::walker;
    use super::*;

    #[test]
    fn a_walker_faces_where_it_goes() {
        for frames in [20, 90] {
            let subject = walker(30.0, frames, 1.0);
            let forward = forward(&subject.movement);
            assert_eq!(forward.len(), frames);
            assert!(forward.iter().all(|forward| forward.distance(DVec3::Z) < 1e-9), "{frames}");
        }
    }
}
