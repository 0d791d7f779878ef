//! A fixed grid of directions: 60 rings of 3 degrees about +Y, each cut into cells about as long as the ring is high.
//!
//! The last place of a coordinate may decide between two cells, never by more than one cell.

use core::f64::consts::{PI, TAU};
use glam::DVec3;
use std::sync::LazyLock;

const RINGS: usize = 60;
/// Height of a ring, 3 degrees.
const RING_RAD: f64 = PI / RINGS as f64;

struct Grid {
    /// Number of a ring's first cell; one more at the end.
    firsts: Vec<u16>,
    /// Unit vectors, by cell.
    centers: Vec<DVec3>,
}

static GRID: LazyLock<Grid> = LazyLock::new(|| {
    let (mut firsts, mut centers) = (vec![0], Vec::new());
    for ring in 0..RINGS {
        let (sin, cos) = libm::sincos((ring as f64 + 0.5) * RING_RAD);
        let cells = (TAU * sin / RING_RAD).round();
        for cell in 0..cells as usize {
            let (across, along) = libm::sincos((cell as f64 + 0.5) / cells * TAU - PI);
            centers.push(DVec3::new(sin * along, cos, sin * across));
        }
        firsts.push(centers.len() as u16);
    }
    Grid { firsts, centers }
});

/// Number of cells, 4,584 or so.
pub fn n_cells() -> usize {
    GRID.centers.len()
}

/// The cell of a direction of unit length; its center is less than 3 degrees away.
pub fn cell_of(direction: DVec3) -> u16 {
    let ring = (libm::acos(direction.y.clamp(-1.0, 1.0)) / RING_RAD) as usize;
    let ring = ring.min(RINGS - 1);
    let (first, end) = (GRID.firsts[ring], GRID.firsts[ring + 1]);
    let share = (libm::atan2(direction.z, direction.x) + PI) / TAU;
    (first + (share * f64::from(end - first)) as u16).min(end - 1)
}

/// The angle from a direction to the nearest center of these cells, radians; pi where there are none.
pub fn angle_to_nearest(direction: DVec3, cells: &[u16]) -> f64 {
    let nearest = cells.iter().map(|&cell| direction.dot(GRID.centers[usize::from(cell)])).fold(-1.0, f64::max);
    libm::acos(nearest.min(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_direction_is_near_the_center_of_its_cell_and_every_cell_is_met() {
        let mut met = vec![false; n_cells()];
        let mut farthest = 0.0_f64;
        for ring in 0..720 {
            let (sin, y) = libm::sincos((f64::from(ring) / 720.0 - 0.5) * PI);
            for step in 0..1440 {
                let (z, x) = libm::sincos(f64::from(step) / 1440.0 * TAU);
                let direction = DVec3::new(x * y, sin, z * y);
                let cell = cell_of(direction);
                met[usize::from(cell)] = true;
                farthest = farthest.max(angle_to_nearest(direction, &[cell]));
            }
        }
        assert!(farthest.to_degrees() < 3.0, "{}", farthest.to_degrees());
        assert!(met.iter().all(|&met| met));
        assert!((4_550..4_620).contains(&n_cells()), "{}", n_cells());
        for odd in [DVec3::ZERO, DVec3::NAN, DVec3::Y * 1.000_001, DVec3::NEG_Y, DVec3::NEG_X] {
            assert!(usize::from(cell_of(odd)) < n_cells());
        }
    }
}
