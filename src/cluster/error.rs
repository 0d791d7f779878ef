//! What clustering refuses.

/// Why vectors or settings can't be clustered. Holds facts; the caller knows which sample an item is.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ClusterError {
    /// A coordinate is NaN, infinite, or larger than any motion (over 1e9).
    #[error("coordinate {lane} of item {item} is {value}, which is no motion")]
    Coordinate {
        /// The item, in the order given.
        item: usize,
        /// The coordinate's place in the canonical vector.
        lane: usize,
        /// What was found.
        value: f32,
    },
    /// A threshold is not a positive finite number.
    #[error("the threshold {found_m2} m^2 is not above zero and finite")]
    Threshold {
        /// What was found, m^2.
        found_m2: f64,
    },
    /// Bands of the tree that do not get anywhere.
    #[error("`{name}` of the bands is {found}; it has to be above 1 and finite")]
    Bands {
        /// Field of the settings.
        name: &'static str,
        /// What was found.
        found: f64,
    },
    /// A weight or time scale of the metric is negative, NaN, infinite or absurdly large.
    #[error("`{name}` is {found}; it has to lie between 0 and 1e6")]
    Weight {
        /// Field of the settings.
        name: &'static str,
        /// What was found.
        found: f64,
    },
    /// More samples than item numbers can count.
    #[error("{found} samples of one plant state; at most {limit} can be numbered")]
    TooMany {
        /// Samples given.
        found: usize,
        /// The limit.
        limit: usize,
    },
    /// A frame does not have 45 features.
    #[error("{found} feature values are not whole frames of 45")]
    FeatureCount {
        /// Values given.
        found: usize,
    },
    /// The merges are no tree: an item out of turn, or made of what is not there yet.
    #[error("merge {at} of the tree is out of turn")]
    Log {
        /// Which merge.
        at: usize,
    },
    /// Whoever was told of the steps wanted no more of them.
    #[error("stopped before it was done")]
    Stopped,
}
