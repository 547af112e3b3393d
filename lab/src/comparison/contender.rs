//! Who is compared: a method with its prior and its number of slots.

use super::coverage::CoverageRecorder;
use super::episode::Trial;
use super::oracle::Oracle;
use super::signature::EnvironmentSignature;
use crate::peers::{
    EkfPacket, EkfTuning, GpMpcTuning, NoCompensation, SlidingTuning, StaleTuning,
    without_identification,
};
use umwelt_core::conjugate::SampleStatistics;
use umwelt_core::controller::Controller;
use umwelt_core::controller::compensation::{
    Compensation, DelayModel, PathFollower, PoseEstimator,
};
use umwelt_core::episode::{Outcome, Scenario, TraceRow};
use umwelt_core::identification::estimate::Channel;
use umwelt_core::settings::{Attribution, Method, Prior, Settings};

/// Time in s that an episode may take beyond the limit: the calibration takes about 20 s at full speed.
const CALIBRATION_TIME: f64 = 60.0;

/// A method.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Approach {
    /// The error distribution measured once on the normal link.
    FixedNormal,
    /// The error distribution measured once on the bad link.
    FixedBad,
    /// Samples only.
    Statistic,
    /// Prior and samples: the thesis's method, whatever its prior.
    Bayesian,
    /// Knows the floor's errors where it stands, and what the robot really plays.
    Oracle,
    /// [`StopWhenStale`](crate::peers::StopWhenStale).
    StopWhenStale,
    /// [`NoCompensation`].
    NoCompensation,
    /// [`EkfPacket`].
    EkfPacket,
    /// [`SlidingMode`](crate::peers::SlidingMode).
    SlidingMode,
    /// [`GpEstimator`](crate::peers::GpEstimator) and [`ShootingMpc`](crate::peers::ShootingMpc).
    GpMpc,
}

impl Approach {
    /// Every method.
    pub const ALL: [Self; 10] = [
        Self::FixedNormal,
        Self::FixedBad,
        Self::Statistic,
        Self::Bayesian,
        Self::Oracle,
        Self::StopWhenStale,
        Self::NoCompensation,
        Self::EkfPacket,
        Self::SlidingMode,
        Self::GpMpc,
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::FixedNormal => "fixed-normal",
            Self::FixedBad => "fixed-bad",
            Self::Statistic => "statistic",
            Self::Bayesian => "bayesian",
            Self::Oracle => "oracle",
            Self::StopWhenStale => "stop-when-stale",
            Self::NoCompensation => "no-compensation",
            Self::EkfPacket => "ekf-packet",
            Self::SlidingMode => "sliding-mode",
            Self::GpMpc => "gp-mpc",
        }
    }

    /// The method of this name.
    ///
    /// ```
    /// use umwelt_lab::comparison::Approach;
    /// assert!(Approach::ALL.iter().all(|it| Approach::named(it.name()) == Some(*it)));
    /// assert_eq!(Approach::named("guess"), None);
    /// ```
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|approach| approach.name() == name)
    }

    /// Whether it learns the environment while it drives.
    pub fn identifies(self) -> bool {
        matches!(self, Self::Statistic | Self::Bayesian)
    }
}

/// One who is compared.
#[derive(Clone, Debug, PartialEq)]
pub struct Contender {
    /// Its name; with the slots its label.
    pub name: String,
    /// Its method.
    pub approach: Approach,
    /// Slots per horizon.
    pub slots: usize,
    /// Its prior, where its method is Bayesian.
    pub prior: Prior,
}

/// Every contender's name, with its method; those of several horizons come with each.
const ALL: [(&str, Approach, &[usize]); 13] = [
    ("fixed-normal", Approach::FixedNormal, &[1, 20]),
    ("fixed-bad", Approach::FixedBad, &[1, 20]),
    ("statistic", Approach::Statistic, &[1, 20]),
    ("bayesian", Approach::Bayesian, &[1, 20]),
    ("bayesian-default", Approach::Bayesian, &[1, 20]),
    ("bayesian-flat", Approach::Bayesian, &[1, 20]),
    ("bayesian-empirical", Approach::Bayesian, &[1, 20]),
    ("oracle", Approach::Oracle, &[1, 20]),
    ("stop-when-stale", Approach::StopWhenStale, &[1]),
    ("no-compensation", Approach::NoCompensation, &[1]),
    ("ekf-packet", Approach::EkfPacket, &[EkfPacket::SLOTS]),
    ("sliding-mode", Approach::SlidingMode, &[1]),
    ("gp-mpc", Approach::GpMpc, &[1]),
];

/// The method whose differences to the others are reported: the thesis's claims are against it.
pub const BASELINE: &str = "statistic";

/// The method that the thesis claims for.
pub const CHAMPION: &str = "bayesian";

/// Every contender, in the order in which they are shown.
pub(super) fn all() -> Vec<Contender> {
    let all = ALL.iter().flat_map(|(name, approach, slots)| {
        slots.iter().map(|slots| Contender {
            name: (*name).to_owned(),
            approach: *approach,
            slots: *slots,
            prior: prior(name, *slots),
        })
    });
    all.collect()
}

/// Every contender's name.
pub fn method_names() -> impl Iterator<Item = &'static str> {
    ALL.iter().map(|(name, ..)| *name)
}

/// The prior that a contender has by default: that of `bayesian` was evolved, with as many slots.
fn prior(name: &str, slots: usize) -> Prior {
    let built_in = match name {
        "bayesian" if slots > 1 => "thesis-20",
        "bayesian" => "thesis",
        "bayesian-flat" => "flat",
        "bayesian-empirical" => "empirical",
        _ => "default",
    };
    Prior::built_in(built_in).unwrap_or_default()
}

impl Contender {
    /// How it is shown: name and slots.
    ///
    /// ```
    /// use umwelt_lab::comparison::ComparisonSettings;
    /// let thesis = ComparisonSettings::scenario("thesis").ok_or("no such scenario")?;
    /// assert_eq!(thesis.contenders[0].label(), "fixed-normal/1");
    /// # Ok::<(), &str>(())
    /// ```
    pub fn label(&self) -> String {
        format!("{}/{}", self.name, self.slots)
    }

    /// The settings of its controller, where `base` are those of all.
    pub fn settings(&self, base: &Settings) -> Settings {
        let settings = Settings { slots: self.slots, prior: self.prior, ..*base };
        match self.approach {
            Approach::FixedNormal => Settings { method: Method::FixedNormal, ..settings },
            Approach::FixedBad => Settings { method: Method::FixedBad, ..settings },
            Approach::Statistic => Settings { method: Method::Statistic, ..settings },
            Approach::Bayesian => Settings { method: Method::Bayesian, ..settings },
            Approach::Oracle => Settings {
                method: Method::FixedNormal,
                attribution: Attribution::Played,
                ..settings
            },
            Approach::StopWhenStale => StaleTuning::default().settings(&settings),
            Approach::NoCompensation => without_identification(&settings),
            Approach::EkfPacket => EkfTuning::default().settings(&settings),
            Approach::SlidingMode => SlidingTuning::default().settings(&settings),
            Approach::GpMpc => GpMpcTuning::default().settings(&settings),
        }
    }

    /// Drives `scenario`, whose controller is told what [`Contender::settings`] says, and whose time limit counts from the
    /// end of the calibration. `known` says how each environment shows in the samples, and `here` which one this is;
    /// empty where that is not asked.
    pub(super) fn drive(
        &self,
        scenario: Scenario,
        known: &[EnvironmentSignature],
        here: usize,
        seed: u64,
    ) -> (Trial, [SampleStatistics; 4]) {
        let (controller, limit) = (scenario.settings, scenario.time_limit);
        let scenario = Scenario { time_limit: limit + CALIBRATION_TIME, ..scenario };
        let run = Run { scenario: &scenario, seed, time_limit: limit };
        match self.approach {
            Approach::FixedNormal
            | Approach::FixedBad
            | Approach::Statistic
            | Approach::Bayesian => run.identifying(self.approach, known, here),
            Approach::Oracle => run.outcome(Oracle::new(&scenario).compensation()),
            Approach::StopWhenStale => run.outcome(StaleTuning::default().compensation()),
            Approach::NoCompensation => run.outcome(NoCompensation::compensation()),
            Approach::EkfPacket => run.outcome(EkfTuning::default().compensation(&controller)),
            Approach::SlidingMode => {
                run.outcome(SlidingTuning::default().compensation(&controller))
            }
            Approach::GpMpc => run.outcome(GpMpcTuning::default().compensation(&controller)),
        }
    }
}

/// One episode of one contender.
struct Run<'a> {
    scenario: &'a Scenario,
    seed: u64,
    /// Longest time in s from the end of the calibration to the arrival.
    time_limit: f64,
}

impl Run<'_> {
    /// Drives it by the thesis's method with any of its beliefs, and measures its belief.
    fn identifying(
        &self,
        approach: Approach,
        known: &[EnvironmentSignature],
        here: usize,
    ) -> (Trial, [SampleStatistics; 4]) {
        let identifies = approach.identifies();
        let is_asked = identifies && known.len() > 1;
        let (mut recognised, mut samples) = (None, None);
        let mut recorder = CoverageRecorder::default();
        let controller = Controller::with(self.scenario.settings, Compensation::STANDARD);
        let show = |_: &TraceRow, controller: &Controller| {
            let belief = controller.belief();
            let taken = belief.samples();
            if is_asked && samples != Some(taken) {
                samples = Some(taken);
                let is_right = EnvironmentSignature::nearest(known, &belief.model()) == here;
                recognised = if is_right { recognised.or(samples) } else { None };
            }
        };
        let driven = self.scenario.drive_observed(controller, self.seed, show, &mut recorder);
        let Ok((outcome, controller)) = driven else { return lost(self.time_limit) };
        let coverage = identifies.then(|| recorder.coverage());
        let statistics = |channel| controller.belief().channel(channel).sample_statistics();
        let trial = Trial { recognised, coverage, ..trial(outcome, self.time_limit) };
        (trial, Channel::ALL.map(statistics))
    }

    /// Drives it by any method; nothing but the outcome counts.
    fn outcome<E: PoseEstimator, D: DelayModel, F: PathFollower>(
        &self,
        compensation: Compensation<E, D, F>,
    ) -> (Trial, [SampleStatistics; 4]) {
        let controller = Controller::with(self.scenario.settings, compensation);
        let driven = self.scenario.drive(controller, self.seed, |_, _| {});
        let Ok((outcome, _)) = driven else { return lost(self.time_limit) };
        (trial(outcome, self.time_limit), Default::default())
    }
}

/// An episode's outcome as it is compared. A robot that has not arrived in time took the whole of it.
fn trial(outcome: Outcome, time_limit: f64) -> Trial {
    let Outcome { arrived, time, max_deviation } = outcome;
    let arrived = arrived && time <= time_limit;
    let time = if arrived { time } else { time_limit };
    Trial { arrived, time, deviation: max_deviation, ..Trial::default() }
}

/// The result of an episode that cannot be simulated: checked before, so it does not happen.
fn lost(time_limit: f64) -> (Trial, [SampleStatistics; 4]) {
    (Trial { time: time_limit, ..Trial::default() }, Default::default())
}
