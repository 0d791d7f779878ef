//! Patterns for names: `*` stands for any characters, all else for itself.

/// Whether a pattern fits a whole text. Upper and lower case differ.
pub fn matches(pattern: &str, text: &str) -> bool {
    let mut parts = pattern.split('*');
    let first = parts.next().unwrap_or("");
    let Some(mut rest) = text.strip_prefix(first) else { return false };
    let Some(last) = parts.next_back() else { return rest.is_empty() };
    // The earliest place of each middle part leaves the most for the others.
    for part in parts {
        match rest.find(part) {
            Some(at) => rest = &rest[at + part.len()..],
            None => return false,
        }
    }
    rest.ends_with(last)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_star_is_anything_and_the_rest_is_itself() {
        for (pattern, text, fits) in [
            ("02_01", "02_01", true),
            ("02_01", "02_011", false),
            ("02_01", "a02_01", false),
            ("*", "", true),
            ("*", "anything/at/all", true),
            ("walk*", "walk-left_001", true),
            ("*_001", "walk_001", true),
            ("*_001", "walk_0012", false),
            ("a*a", "a", false),
            ("a*a", "aa", true),
            ("*b*c*", "abbbc", true),
            ("*b*c*", "acb", false),
            ("*ab", "aab", true),
            ("", "", true),
            ("", "x", false),
            ("w?lk", "walk", false),
            ("é*", "élan", true),
        ] {
            assert_eq!(matches(pattern, text), fits, "{pattern} on {text}");
        }
    }
}
