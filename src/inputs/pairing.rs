//! Which ASF belongs to an AMC file, by their names in one folder (DESIGN 3, Names).

/// How a skeleton was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Pairing {
    /// `take.amc` and `take.asf`, or `02_01.amc` and `02.asf`: by name.
    ByName,
    /// The only ASF there is: a guess.
    OnlyOne,
}

/// The skeleton of a motion, as an index into the stems of the folder's ASF files: same stem; stem before the
/// last `_`; the only one. Upper and lower case differ only where that decides.
pub(crate) fn pair(motion: &str, skeletons: &[String]) -> Option<(usize, Pairing)> {
    let subject = motion.rsplit_once('_').map(|(subject, _)| subject);
    let by_name = [Some(motion), subject].into_iter().flatten().find_map(|wanted| {
        let exact = skeletons.iter().position(|stem| stem == wanted);
        exact.or_else(|| skeletons.iter().position(|stem| stem.to_lowercase() == wanted.to_lowercase()))
    });
    match by_name {
        Some(index) => Some((index, Pairing::ByName)),
        None if skeletons.len() == 1 => Some((0, Pairing::OnlyOne)),
        None => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(motion: &str, skeletons: &[&str]) -> Option<(usize, Pairing)> {
        pair(motion, &skeletons.iter().map(|&stem| stem.to_owned()).collect::<Vec<_>>())
    }

    #[test]
    fn the_rules_hold_in_their_order() {
        assert_eq!(found("02_01", &["02", "02_01", "03"]), Some((1, Pairing::ByName)));
        assert_eq!(found("02_01", &["01", "02", "03"]), Some((1, Pairing::ByName)));
        assert_eq!(found("02_01_cut", &["02", "02_01"]), Some((1, Pairing::ByName)));
        assert_eq!(found("walk", &["actor"]), Some((0, Pairing::OnlyOne)));
        assert_eq!(found("02_01", &["03"]), Some((0, Pairing::OnlyOne)));
        assert_eq!(found("walk", &["actor", "other"]), None);
        assert_eq!(found("walk", &[]), None);
        assert_eq!(found("02_01_cut", &["02", "03"]), None);
    }

    #[test]
    fn case_matters_only_where_it_decides() {
        assert_eq!(found("Take_01", &["other", "take_01"]), Some((1, Pairing::ByName)));
        assert_eq!(found("Take_01", &["take_01", "Take_01"]), Some((1, Pairing::ByName)));
        assert_eq!(found("Bob_1", &["BOB", "ann"]), Some((0, Pairing::ByName)));
    }
}
