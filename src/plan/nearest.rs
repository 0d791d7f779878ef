//! The valid name that a mistyped one comes nearest to.

/// The nearest of the names, if one is near: few letters differ, or one holds the other.
pub(crate) fn nearest<'a>(wrong: &str, names: &[&'a str]) -> Option<&'a str> {
    let wrong = wrong.to_lowercase();
    let distances = names.iter().map(|&name| (strsim::osa_distance(&wrong, name), name));
    let (distance, near) = distances.min()?;
    let length = wrong.chars().count();
    if distance <= (length / 3).max(1) && distance < near.chars().count() {
        return Some(near);
    }
    names.iter().copied().find(|name| length >= 4 && (name.contains(wrong.as_str()) || wrong.contains(name)))
}

/// "`a`, `b` or `c`".
pub(crate) fn list(names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    match quoted.split_last() {
        None => "nothing".to_owned(),
        Some((only, [])) => only.clone(),
        Some((last, others)) => format!("{} or {last}", others.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_is_near_and_far_is_nothing() {
        let names = ["max_height_m", "max_speed_mps", "close_gap_s"];
        assert_eq!(nearest("max_hieght_m", &names), Some("max_height_m"));
        assert_eq!(nearest("Max_Height_M", &names), Some("max_height_m"));
        assert_eq!(nearest("gap_s", &names), Some("close_gap_s"));
        assert_eq!(nearest("threshold", &names), None);
        assert_eq!(nearest("x", &["a"]), None);
        assert_eq!(nearest("anything", &[]), None);
    }

    #[test]
    fn lists_read_like_sentences() {
        assert_eq!(list(&["a"]), "`a`");
        assert_eq!(list(&["a", "b", "c"]), "`a`, `b` or `c`");
        assert_eq!(list(&[]), "nothing");
    }
}
