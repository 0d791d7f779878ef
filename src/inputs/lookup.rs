//! Finding a clip by the name that a user types.

/// Why a name finds no clip.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LookupError {
    /// Nothing fits; these indices come nearest, best first.
    Nothing {
        /// At most three.
        near: Vec<usize>,
    },
    /// All of these fit equally.
    Several {
        /// Ascending.
        clips: Vec<usize>,
    },
}

/// Finds a clip among (source, name) pairs: by `source/name` or `name`, else by the name's last component, else by a
/// prefix of either that only one clip has.
///
/// # Errors
/// [`LookupError`]: nothing fits, or several do on the first level where any does.
pub fn look_up(clips: &[(&str, &str)], wanted: &str) -> Result<usize, LookupError> {
    let is_name = |&(source, name): &(&str, &str)| name == wanted || is_whole(source, name, wanted);
    let is_last = |&(_, name): &(&str, &str)| last(name) == wanted;
    let is_prefix = |&(source, name): &(&str, &str)| {
        name.starts_with(wanted) || last(name).starts_with(wanted) || whole(source, name).starts_with(wanted)
    };
    let fitting = |fits: &dyn Fn(&(&str, &str)) -> bool| -> Vec<usize> {
        (0..clips.len()).filter(|&index| !wanted.is_empty() && fits(&clips[index])).collect()
    };
    for found in [fitting(&is_name), fitting(&is_last), fitting(&is_prefix)] {
        match found[..] {
            [] => {}
            [only] => return Ok(only),
            _ => return Err(LookupError::Several { clips: found }),
        }
    }
    Err(LookupError::Nothing { near: nearest(clips, wanted) })
}

fn nearest(clips: &[(&str, &str)], wanted: &str) -> Vec<usize> {
    let distance =
        |&(_, name): &(&str, &str)| strsim::osa_distance(name, wanted).min(strsim::osa_distance(last(name), wanted));
    let mut near: Vec<(usize, usize)> = clips.iter().map(distance).zip(0..).collect();
    near.retain(|&(distance, _)| distance <= wanted.chars().count() / 3 + 1);
    near.sort();
    near.into_iter().map(|(_, index)| index).take(3).collect()
}

fn is_whole(source: &str, name: &str, wanted: &str) -> bool {
    wanted.strip_prefix(source).and_then(|rest| rest.strip_prefix('/')) == Some(name)
}

fn whole(source: &str, name: &str) -> String {
    format!("{source}/{name}")
}

fn last(name: &str) -> &str {
    name.rsplit('/').next().unwrap_or(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLIPS: [(&str, &str); 6] = [
        ("cmu", "01/01_01"),
        ("cmu", "02/02_01"),
        ("cmu", "02/02_010"),
        ("studio", "02_01"),
        ("studio", "walk"),
        ("studio", "run/walk"),
    ];

    #[test]
    fn the_whole_name_comes_first_then_the_last_component_then_a_prefix() {
        assert_eq!(look_up(&CLIPS, "cmu/02/02_01"), Ok(1));
        assert_eq!(look_up(&CLIPS, "02_01"), Ok(3));
        assert_eq!(look_up(&CLIPS, "walk"), Ok(4));
        assert_eq!(look_up(&CLIPS, "01_01"), Ok(0));
        assert_eq!(look_up(&CLIPS, "01"), Ok(0));
        assert_eq!(look_up(&CLIPS, "02/02_010"), Ok(2));
        assert_eq!(look_up(&CLIPS, "studio/r"), Ok(5));
    }

    #[test]
    fn what_fits_several_names_them_and_what_fits_none_names_the_nearest() {
        assert_eq!(look_up(&CLIPS, "02"), Err(LookupError::Several { clips: vec![1, 2, 3] }));
        assert_eq!(look_up(&CLIPS, "cmu/0"), Err(LookupError::Several { clips: vec![0, 1, 2] }));
        assert_eq!(look_up(&CLIPS, "wlak"), Err(LookupError::Nothing { near: vec![4, 5] }));
        assert_eq!(look_up(&CLIPS, ""), Err(LookupError::Nothing { near: vec![] }));
        assert_eq!(look_up(&[], "x"), Err(LookupError::Nothing { near: vec![] }));
    }
}
