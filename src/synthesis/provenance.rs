//! Where every part of every frame of a graft comes from (SCHEMA, provenance).

use super::parts::Part;
use super::tables::ProvenanceRow;

/// The origin of a graft's frames: the donor's share in the grafted parts; all else is the base's.
#[derive(Clone, Debug, PartialEq)]
pub struct Provenance {
    /// Parts taken from the donor, in order.
    pub parts: Vec<Part>,
    /// The donor's share in each frame, 0..1.
    pub weights: Vec<f64>,
    /// The donor's fractional frame in each frame; means nothing where the share is 0.
    pub donor_frames: Vec<f64>,
}

impl Provenance {
    /// The rows of the table by frame, part, then base before donor; a row for every part of every frame, two where the
    /// parents blend.
    pub fn rows(&self, base_clip_id: u32, donor_clip_id: u32) -> impl Iterator<Item = ProvenanceRow> {
        self.weights.iter().zip(&self.donor_frames).enumerate().flat_map(move |(frame, (&weight, &donor_frame))| {
            let frame = frame as u32;
            Part::ALL.into_iter().flat_map(move |part| {
                let weight = if self.parts.contains(&part) { weight as f32 } else { 0.0 };
                let row = |parent: u32, parent_frame: f64, weight: f32| {
                    (weight > 0.0).then_some(ProvenanceRow { frame, part: part.name(), parent, parent_frame, weight })
                };
                let base = row(base_clip_id, f64::from(frame), 1.0 - weight);
                base.into_iter().chain(row(donor_clip_id, donor_frame, weight))
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_rows_where_two_blend() {
        let provenance = Provenance {
            parts: vec![Part::Head, Part::ArmRight],
            weights: vec![0.0, 0.25, 1.0],
            donor_frames: vec![7.0, 7.5, 8.5],
        };
        let rows: Vec<ProvenanceRow> = provenance.rows(3, 9).collect();
        assert_eq!(rows.len(), 6 + 8 + 6);
        assert!(rows[..6].iter().all(|row| (row.parent, row.weight) == (3, 1.0)));
        let blended: Vec<_> = rows[6..14]
            .iter()
            .filter(|row| row.part == "head")
            .map(|row| (row.parent, row.parent_frame, row.weight))
            .collect();
        assert_eq!(blended, [(3, 1.0, 0.75), (9, 7.5, 0.25)]);
        let taken: Vec<_> = rows[14..].iter().filter(|row| row.parent == 9).map(|row| row.part).collect();
        assert_eq!(taken, ["head", "arm_right"]);
    }
}
