//! Which motions may be composed (T 5.4.2): hard rules, since no figure knows that running arms on a stander are absurd.

use crate::annotate::labels::Gait;
use serde::{Deserialize, Serialize};

/// A rule that allows a donor's upper body over a base's legs. Written base first: `walk<-stand`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[allow(missing_docs, reason = "base, then donor")]
pub enum Rule {
    #[serde(rename = "stand<-stand")]
    StandStand,
    #[serde(rename = "walk<-stand")]
    WalkStand,
    #[serde(rename = "run<-stand")]
    RunStand,
    #[serde(rename = "jump<-stand")]
    JumpStand,
    #[serde(rename = "walk<-walk")]
    WalkWalk,
    #[serde(rename = "run<-walk")]
    RunWalk,
    #[serde(rename = "walk<-run")]
    WalkRun,
    #[serde(rename = "run<-run")]
    RunRun,
    #[serde(rename = "jump<-jump")]
    JumpJump,
}

impl Rule {
    /// All nine.
    pub const ALL: [Rule; 9] = [
        Rule::StandStand,
        Rule::WalkStand,
        Rule::RunStand,
        Rule::JumpStand,
        Rule::WalkWalk,
        Rule::RunWalk,
        Rule::WalkRun,
        Rule::RunRun,
        Rule::JumpJump,
    ];

    /// The rule for a pair of classes. None: not allowed; `other` and `unknown` never are.
    pub fn of(base: Gait, donor: Gait) -> Option<Rule> {
        Rule::ALL.into_iter().find(|rule| (rule.base(), rule.donor()) == (base, donor))
    }

    /// Class of the base.
    pub fn base(self) -> Gait {
        self.classes()[0]
    }

    /// Class of the donor.
    pub fn donor(self) -> Gait {
        self.classes()[1]
    }

    /// The word in recipes, base first.
    pub fn name(self) -> &'static str {
        [
            "stand<-stand",
            "walk<-stand",
            "run<-stand",
            "jump<-stand",
            "walk<-walk",
            "run<-walk",
            "walk<-run",
            "run<-run",
            "jump<-jump",
        ][self as usize]
    }

    /// The rule of that name.
    pub fn from_name(name: &str) -> Option<Rule> {
        Rule::ALL.into_iter().find(|rule| rule.name() == name)
    }

    /// Whether base and donor both step, so that ankle passes lay one over the other and the arms keep time with the legs.
    pub fn is_cyclic(self) -> bool {
        let steps = |gait: Gait| matches!(gait, Gait::Walk | Gait::Run);
        steps(self.base()) && steps(self.donor())
    }

    /// Whether the base's arms must be idle where the donor's are laid over them (GRAFTS 3).
    pub fn needs_idle_arms(self) -> bool {
        self == Rule::StandStand
    }

    /// The share of grafts that passed the judge in the study (GRAFTS 5). None: not measured, there were no jumps.
    pub fn expected_pass_share(self) -> Option<f64> {
        match self {
            Rule::StandStand => Some(0.80),
            Rule::WalkStand => Some(0.93),
            Rule::RunStand => Some(0.62),
            Rule::WalkWalk => Some(0.85),
            Rule::RunWalk => Some(0.68),
            Rule::WalkRun => Some(0.82),
            Rule::RunRun => Some(0.78),
            Rule::JumpStand | Rule::JumpJump => None,
        }
    }

    fn classes(self) -> [Gait; 2] {
        use Gait::*;
        match self {
            Rule::StandStand => [Stand, Stand],
            Rule::WalkStand => [Walk, Stand],
            Rule::RunStand => [Run, Stand],
            Rule::JumpStand => [Jump, Stand],
            Rule::WalkWalk => [Walk, Walk],
            Rule::RunWalk => [Run, Walk],
            Rule::WalkRun => [Walk, Run],
            Rule::RunRun => [Run, Run],
            Rule::JumpJump => [Jump, Jump],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Gait::*;

    #[test]
    fn the_product_is_that_of_the_thesis() {
        let classes = [Unknown, Stand, Walk, Run, Jump, Other];
        let mut allowed = Vec::new();
        for base in classes {
            for donor in classes {
                allowed.extend(Rule::of(base, donor).map(Rule::name));
            }
        }
        allowed.sort_unstable();
        let mut named = Rule::ALL.map(Rule::name);
        named.sort_unstable();
        assert_eq!(allowed, named);
        assert_eq!(Rule::of(Stand, Run), None);
        assert_eq!(Rule::of(Walk, Other), None);
        assert_eq!(Rule::of(Jump, Walk), None);
        assert_eq!(Rule::of(Walk, Run).map(Rule::name), Some("walk<-run"));
    }

    #[test]
    fn names_say_base_and_donor() {
        for rule in Rule::ALL {
            assert_eq!(rule.name(), format!("{}<-{}", rule.base().name(), rule.donor().name()));
            assert_eq!(Rule::from_name(rule.name()), Some(rule));
            let written = serde_json::to_string(&rule).unwrap_or_default();
            assert_eq!(written, format!("\"{}\"", rule.name()));
        }
    }
}
