//! The class that a clip's name promises.

use crate::annotate::Gait;
use regex::Regex;

/// A rule: clips of such names are of that class.
#[derive(Clone, Debug)]
pub struct NameRule {
    /// Fits somewhere in `source/name`.
    pub name: Regex,
    /// The class. [`Gait::Unknown`]: nobody knows, and the clip is left out.
    pub gait: Gait,
}

/// Rules in order; the first that fits decides.
#[derive(Clone, Debug, Default)]
pub struct NameRules {
    /// In order.
    pub rules: Vec<NameRule>,
}

impl NameRules {
    /// The class of a clip by its full name, `source/name`. None: no rule fits, or the one that does says that nobody
    /// knows.
    pub fn class_of(&self, full_name: &str) -> Option<Gait> {
        let rule = self.rules.iter().find(|rule| rule.name.is_match(full_name));
        rule.map(|rule| rule.gait).filter(|&gait| gait != Gait::Unknown)
    }
}

#[cfg(test)]
mod tests {
    #![expect(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn the_first_rule_that_fits_decides() {
        let rule = |name: &str, gait| NameRule { name: Regex::new(name).unwrap(), gait };
        let rules = NameRules {
            rules: vec![rule("run_elderly", Gait::Walk), rule("^odd/", Gait::Unknown), rule("_run_", Gait::Run)],
        };
        assert_eq!(rules.class_of("a/x_run_elderly_001"), Some(Gait::Walk));
        assert_eq!(rules.class_of("a/x_run_active_001"), Some(Gait::Run));
        assert_eq!(rules.class_of("odd/x_run_active_001"), None);
        assert_eq!(rules.class_of("a/x_bow_active_001"), None);
        assert_eq!(NameRules::default().class_of("a"), None);
    }
}
