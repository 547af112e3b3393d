//! What is wrong with the parameters of a belief.

/// A parameter outside the domain of its distribution.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ConjugateError {
    /// The mean is infinite or not a number.
    #[error("mu must be finite, not {0}")]
    MuNotFinite(f64),
    /// The weight of the mean is not positive and finite.
    #[error("k must be positive and finite, not {0}")]
    KNotPositive(f64),
    /// The degrees of freedom are not positive and finite.
    #[error("r must be positive and finite, not {0}")]
    RNotPositive(f64),
    /// The sum of squares is not positive and finite.
    #[error("s must be positive and finite, not {0}")]
    SNotPositive(f64),
    /// The number of successes is not positive and finite.
    #[error("alpha must be positive and finite, not {0}")]
    AlphaNotPositive(f64),
    /// The number of failures is not positive and finite.
    #[error("beta must be positive and finite, not {0}")]
    BetaNotPositive(f64),
}
