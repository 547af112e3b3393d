//! What is asked of a comparison, all filled in, and the limits of it.

use crate::number;
use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;

/// Methods that are asked for, of different names.
pub const METHODS: RangeInclusive<usize> = 1..=64;
/// Trials of a contender in an environment; one alone has no interval.
pub const TRIALS: RangeInclusive<u64> = 2..=10_000;
/// Most episodes of one comparison (contenders x environments x trials): the evaluation of each is held in memory.
pub const MAX_EPISODES: u64 = 200_000;

/// Every method, and each with its numbers of slots, in the order of the alphabet.
pub const KNOWN_METHODS: [&str; 34] = [
    "bayesian",
    "bayesian-default",
    "bayesian-default/1",
    "bayesian-default/20",
    "bayesian-empirical",
    "bayesian-empirical/1",
    "bayesian-empirical/20",
    "bayesian-flat",
    "bayesian-flat/1",
    "bayesian-flat/20",
    "bayesian/1",
    "bayesian/20",
    "ekf-packet",
    "ekf-packet/20",
    "fixed-bad",
    "fixed-bad/1",
    "fixed-bad/20",
    "fixed-normal",
    "fixed-normal/1",
    "fixed-normal/20",
    "gp-mpc",
    "gp-mpc/1",
    "no-compensation",
    "no-compensation/1",
    "oracle",
    "oracle/1",
    "oracle/20",
    "sliding-mode",
    "sliding-mode/1",
    "statistic",
    "statistic/1",
    "statistic/20",
    "stop-when-stale",
    "stop-when-stale/1",
];

/// The name of the prior that the contender `bayesian` has where nothing is said: the thesis's, evolved with as many
/// slots. With more than one it is the built-in prior `thesis-20`.
pub const DEFAULT_PRIOR: &str = "thesis";

/// What is driven, and in which environments.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
#[schema(as = Scenario)]
pub enum Scenario {
    /// The thesis's round trip of 0.9 m on a hard floor over a normal and a bad link, a robot without lag.
    #[default]
    Thesis,
    /// The thesis's corridor, there and back; the robot lags and its controller knows it.
    ThesisReal,
    /// 2.4 m there and back; the floor is slippery from 0.8 to 1.6 m.
    FloorChange,
    /// The same way; the link is bad from 0.8 to 1.6 m.
    LinkChange,
    /// The same way over bursty Wi-Fi with silences, on a hard and on a slippery floor.
    Bursty,
    /// The same way; nothing gets through for 4 s.
    Outage,
    /// The thesis's round trip with a robot that is not as its controller was told.
    Systematic,
}

impl Scenario {
    /// Every scenario.
    pub const ALL: [Self; 7] = [
        Self::Thesis,
        Self::ThesisReal,
        Self::FloorChange,
        Self::LinkChange,
        Self::Bursty,
        Self::Outage,
        Self::Systematic,
    ];

    /// The name on the wire, and in lab.
    pub fn name(self) -> &'static str {
        match self {
            Self::Thesis => "thesis",
            Self::ThesisReal => "thesis-real",
            Self::FloorChange => "floor-change",
            Self::LinkChange => "link-change",
            Self::Bursty => "bursty",
            Self::Outage => "outage",
            Self::Systematic => "systematic",
        }
    }

    /// The scenario of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|scenario| scenario.name() == name)
    }
}

/// What a comparison was asked for, all filled in.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ComparisonSpec)]
pub struct Spec {
    /// What is driven; expect others.
    pub scenario: String,
    /// Who is compared: method and slots per horizon, as `bayesian/20`.
    pub methods: Vec<String>,
    /// Where.
    pub environments: Vec<String>,
    /// Trials of each contender in each environment.
    pub trials: u64,
    /// Of everything random.
    pub seed: u64,
    /// Time after the calibration beyond which a robot counts as not arrived, and which its trial then took.
    #[serde(serialize_with = "number::finite")]
    pub time_limit_s: f64,
    /// The name of the prior of the contender `bayesian`, `thesis` standing for `thesis-20` with more than one slot; null
    /// where it is not compared.
    pub prior: Option<String>,
}
