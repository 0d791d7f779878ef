//! Why a recipe can't be made: typed, so that they can be counted; one row of `made` each.

use super::parts::Part;

/// A reason not to make a clip.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Refusal {
    /// No shift pairs three ankle passes of base and donor.
    #[error("no three ankle passes of base and donor can be paired")]
    TooFewPairs,
    /// The donor would have to be slowed or hurried too much.
    #[error("the donor would run at {low:.2} to {high:.2} of its speed")]
    RateOutOfRange {
        /// Least factor.
        low: f64,
        /// Greatest factor.
        high: f64,
    },
    /// The pair has fewer alternates than that.
    #[error("alternate {wanted} of {found}")]
    NoSuchAlternate {
        /// Asked for, from 0.
        wanted: usize,
        /// Alternates of the pair.
        found: usize,
    },
    /// Joint names, parents or channels differ.
    #[error("base and donor are not of one layout")]
    LayoutDiffers,
    /// No sensible resampling lies between the rates of base and donor.
    #[error("the rates of base and donor, {base_hz} and {donor_hz} Hz, lie too far apart")]
    RatesTooFarApart {
        /// Of the base.
        base_hz: f64,
        /// Of the donor.
        donor_hz: f64,
    },
    /// An action is never cut (GRAFTS 3).
    #[error("the base lasts {held_s:.3} s, the donor's action ends at {needed_s:.3} s")]
    BaseTooShort {
        /// When the action would end.
        needed_s: f64,
        /// When the base's last frame is.
        held_s: f64,
    },
    /// The action would begin before the base, has no length, or is no range of the donor.
    #[error("no such place for the action")]
    BadPlacement,
    /// An arm of the base moves where the donor's should (stand <- stand).
    #[error("the base's {} moves inside the window", .0.name())]
    BaseArmBusy(Part),
    /// No arm of the donor does anything.
    #[error("no arm of the donor is active")]
    NoActiveArm,
    /// Legs and root make the base; an empty list makes nothing; a skeleton may lack the part.
    #[error("{} can't be grafted", .0.map_or("nothing", Part::name))]
    NotGraftable(Option<Part>),
    /// The channels of a joint are no product of turns about different axes.
    #[error("the channels of joint {joint:?} can't be solved for")]
    UnsolvableChannels {
        /// Its name.
        joint: String,
    },
}

impl Refusal {
    /// A short stable name, for `made.reasons` and counts.
    pub fn name(&self) -> &'static str {
        match self {
            Refusal::TooFewPairs => "too-few-pairs",
            Refusal::RateOutOfRange { .. } => "rate-out-of-range",
            Refusal::NoSuchAlternate { .. } => "no-such-alternate",
            Refusal::LayoutDiffers => "layout-differs",
            Refusal::RatesTooFarApart { .. } => "rates-too-far-apart",
            Refusal::BaseTooShort { .. } => "base-too-short",
            Refusal::BadPlacement => "bad-placement",
            Refusal::BaseArmBusy(_) => "base-arm-busy",
            Refusal::NoActiveArm => "no-active-arm",
            Refusal::NotGraftable(_) => "not-graftable",
            Refusal::UnsolvableChannels { .. } => "unsolvable-channels",
        }
    }
}
