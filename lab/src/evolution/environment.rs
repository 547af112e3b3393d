//! Named simulated environments, and what counts as fit in them.

use super::episode::Evaluation;
use umwelt_core::link::LinkModel;
use umwelt_core::plant::Slip;

/// The names that [`TrainingEnvironment::preset`] knows; the first two are the thesis's.
pub const ENVIRONMENTS: [&str; 6] =
    ["normal", "bad-link", "bursty-link", "slippery", "loaded", "towing"];

/// Deviations below this many m count as this many: half of the tolerance at a waypoint, so that no request asks for less.
/// Without it 1/d is without bound, and the mean fitness over a few trials says who was lucky with the late packets:
/// on the thesis's bad link, one command per reply, 5 % of the episodes stray by less.
pub const SMALLEST_DEVIATION: f64 = 0.005;

/// What is asked of an individual in an environment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Fitness {
    /// Speed, where the deviation is small enough (thesis eq. 52).
    Normal,
    /// Accuracy, where it does not take too long (thesis eq. 53).
    Bad,
}

/// Limits beyond which an individual has no fitness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitnessLimits {
    /// Largest deviation in m (D^max of eq. 52; thesis table 2: 100 mm).
    pub deviation: f64,
    /// Longest time in s from the end of the calibration to the arrival (T^max of eq. 53, which the thesis does not
    /// give).
    pub time: f64,
}

impl Default for FitnessLimits {
    /// 100 mm (thesis table 2), and 60 s: three times what a careful robot takes for the thesis's round trip over
    /// the bad link.
    fn default() -> Self {
        Self { deviation: 0.100, time: 60.0 }
    }
}

impl Fitness {
    /// Fitness of one episode, with T = 1 s and D = 1 m: the constants cancel when it is normalised.
    ///
    /// E_normal = T/t where d <= D^max, else 0 (eq. 52); E_bad = D/d where t <= T^max, else 0 (eq. 53). A robot that
    /// does not arrive takes for ever, so it has none by either.
    pub fn of(self, limits: &FitnessLimits, evaluation: &Evaluation) -> f64 {
        let Evaluation { arrived, time, deviation, .. } = *evaluation;
        let counts = arrived
            && match self {
                Self::Normal => deviation <= limits.deviation,
                Self::Bad => time <= limits.time,
            };
        match self {
            _ if !counts => 0.0,
            Self::Normal => 1.0 / time,
            Self::Bad => 1.0 / deviation.max(SMALLEST_DEVIATION),
        }
    }

    /// Fitness of an episode that just keeps the limit of the other quantity: the unit where fixed-normal never has
    /// any fitness.
    pub(super) fn at_limit(self, limits: &FitnessLimits) -> f64 {
        match self {
            Self::Normal => 1.0 / limits.time,
            Self::Bad => 1.0 / limits.deviation,
        }
    }
}

/// A simulated environment in which individuals are tried.
#[derive(Clone, Debug, PartialEq)]
pub struct TrainingEnvironment {
    /// Its name.
    pub name: String,
    /// The floor.
    pub slip: Slip,
    /// The link.
    pub link: LinkModel,
    /// What is asked there.
    pub fitness: Fitness,
    /// Its weight among the environments, positive.
    pub weight: f64,
}

impl TrainingEnvironment {
    /// The environment called `name`, one of [`ENVIRONMENTS`].
    ///
    /// ```
    /// use umwelt_lab::evolution::{ENVIRONMENTS, Fitness, TrainingEnvironment};
    /// assert!(ENVIRONMENTS.iter().all(|name| TrainingEnvironment::preset(name).is_some()));
    /// assert_eq!(TrainingEnvironment::preset("bad-link").map(|it| it.fitness), Some(Fitness::Bad));
    /// ```
    pub fn preset(name: &str) -> Option<Self> {
        let (slip, link, fitness) = match name {
            "normal" => (Slip::HARD, "normal", Fitness::Normal),
            "bad-link" => (Slip::HARD, "bad", Fitness::Bad),
            "bursty-link" => (Slip::HARD, "wifi-bursty", Fitness::Bad),
            "slippery" => (Slip::SLIPPERY, "normal", Fitness::Bad),
            "loaded" => (Slip::LOADED, "normal", Fitness::Normal),
            "towing" => (Slip::TOWING, "normal", Fitness::Bad),
            _ => return None,
        };
        let link = LinkModel::preset(link)?;
        Some(Self { name: name.to_owned(), slip, link, fitness, weight: 1.0 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn evaluation(arrived: bool, time: f64, deviation: f64) -> Evaluation {
        Evaluation { arrived, time, deviation, ..Evaluation::default() }
    }

    #[test]
    fn fast_is_fit_where_it_stays_near_the_path() {
        let fit = |it| Fitness::Normal.of(&FitnessLimits::default(), &it);
        assert_eq!(fit(evaluation(true, 10.0, 0.1)), 0.1);
        assert_eq!(fit(evaluation(true, 10.0, 0.100_1)), 0.0);
        assert_eq!(fit(evaluation(false, 10.0, 0.01)), 0.0);
        assert_eq!(fit(evaluation(true, 200.0, 0.01)), 0.005);
    }

    #[test]
    fn near_the_path_is_fit_where_it_does_not_take_too_long() {
        let fit = |it| Fitness::Bad.of(&FitnessLimits::default(), &it);
        assert_eq!(fit(evaluation(true, 60.0, 0.02)), 50.0);
        assert_eq!(fit(evaluation(true, 60.1, 0.02)), 0.0);
        assert_eq!(fit(evaluation(false, 20.0, 0.02)), 0.0);
        assert_eq!(fit(evaluation(true, 20.0, 0.0)), 1.0 / SMALLEST_DEVIATION);
    }

    #[test]
    fn the_environments_of_the_thesis_differ_in_their_link_alone() {
        let [normal, bad] =
            ["normal", "bad-link"].map(|name| TrainingEnvironment::preset(name).unwrap());
        assert_eq!(normal.slip, bad.slip);
        assert_ne!(normal.link, bad.link);
        assert_eq!(TrainingEnvironment::preset("lava"), None);
    }
}
