//! What is believed about the floor before any sample.

use crate::check::{Check, Range, Validate};
use crate::id::PriorId;
use crate::named::NameOr;
use crate::schema::ToSchema;
use serde::{Deserialize, Deserializer, Serialize};

/// An error of ten times the commanded motion is no error ratio any more.
pub const MU: Range = Range::new(-10.0, 10.0, "");
/// From nothing believed to more samples than a robot takes in its life.
pub const WEIGHT: Range = Range::new(1e-6, 1e9, "");
/// Sum of squares for the weights and ratios above.
pub const SUM_OF_SQUARES: Range = Range::new(1e-12, 1e12, "");

/// Belief about one channel's error ratio: normal, inverse chi-squared (thesis eq. 32-34).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ChannelPrior)]
pub struct ChannelPrior {
    /// Expected ratio.
    pub mu: f64,
    /// Samples that the expectation is worth.
    pub k: f64,
    /// Degrees of freedom of the variance; above 2 it has an expectation.
    pub r: f64,
    /// Sum of squares: r times the variance of the ratio over 100 ms.
    pub s: f64,
}

impl Validate for ChannelPrior {
    fn check(&self, check: &mut Check) {
        check.number("mu", self.mu, MU);
        check.number("k", self.k, WEIGHT);
        check.number("r", self.r, WEIGHT);
        check.number("s", self.s, SUM_OF_SQUARES);
    }
}

/// Belief about each channel before any sample. A channel that is left out has the weak default.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default)]
#[schema(as = ChannelPriors)]
pub struct Prior {
    /// Forward error per metre commanded.
    pub forward: ChannelPrior,
    /// Lateral error per metre commanded.
    pub lateral: ChannelPrior,
    /// Heading error per radian commanded.
    pub turn: ChannelPrior,
    /// Heading error in rad per metre commanded; used where `drift` is on.
    pub drift: ChannelPrior,
}

impl Default for Prior {
    /// A ratio of standard deviation 0.15 over 100 ms, of lateral slip and drift a third of it, four degrees of freedom
    /// so that its variance exists, and a mean that one sample can move half way.
    fn default() -> Self {
        let weak = |sd: f64| ChannelPrior { mu: 0.0, k: 1.0, r: 4.0, s: sd * sd * 2.0 };
        Self { forward: weak(0.15), lateral: weak(0.05), turn: weak(0.15), drift: weak(0.05) }
    }
}

impl Validate for Prior {
    fn check(&self, check: &mut Check) {
        check.field("forward", |check| self.forward.check(check));
        check.field("lateral", |check| self.lateral.check(check));
        check.field("turn", |check| self.turn.check(check));
        check.field("drift", |check| self.drift.check(check));
    }
}

/// The prior that a robot begins with: the name of one, or one of its own.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[serde(untagged)]
#[schema(as = PriorChoice)]
pub enum PriorChoice {
    /// The name of a prior: `default`, `flat`, `thesis`, or one of `GET /v1/priors`.
    Named(String),
    /// The prior itself.
    Inline(Prior),
}

/// The name of the weak prior that robots have where nothing is said.
pub const DEFAULT_PRIOR: &str = "default";

impl Default for PriorChoice {
    fn default() -> Self {
        Self::Named(DEFAULT_PRIOR.to_owned())
    }
}

impl From<&PriorId> for PriorChoice {
    fn from(name: &PriorId) -> Self {
        Self::Named(name.to_string())
    }
}

impl<'de> Deserialize<'de> for PriorChoice {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let read = NameOr::read(deserializer, "the name of a prior, or an object with one")?;
        Ok(match read {
            NameOr::Name(name) => Self::Named(name),
            NameOr::Thing(prior) => Self::Inline(prior),
        })
    }
}

impl PriorChoice {
    /// The name of the prior, if it has one.
    pub fn name(&self) -> Option<&str> {
        match self {
            Self::Named(name) => Some(name),
            Self::Inline(_) => None,
        }
    }

    /// Checks what field `field` holds.
    pub(super) fn check(&self, field: &str, check: &mut Check) {
        match self {
            Self::Named(name) => check.id(field, name),
            Self::Inline(prior) => check.field(field, |check| prior.check(check)),
        }
    }
}
