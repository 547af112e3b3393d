//! Whether a belief is honest: robots whose floor is drawn from the prior, and what the posterior then says of it.
//!
//! Simulation-based calibration (Talts, Betancourt, Simpson, Vehtari & Gelman 2018): where the truth is drawn from the
//! prior and the data from the truth, the rank of the truth among draws from the posterior is uniform, and a 90 % interval
//! holds it in 90 % of the runs. Any error of window, noise discount or update shows as a slope, a hump or a bowl in the
//! histogram of ranks. The robot is simulated whole, with camera noise, lag and dead time, and drives by its belief.

use super::coverage::{Coverage, CoverageRecorder};
use crate::seeds::{self, Purpose};
use rand_distr::{ChiSquared, Distribution, StandardNormal};
use rand_pcg::Pcg64;
use umwelt_core::conjugate::NormalInverseChiSquared;
use umwelt_core::controller::Controller;
use umwelt_core::controller::compensation::Compensation;
use umwelt_core::episode::{EpisodeError, Scenario};
use umwelt_core::geometry::{Point, Pose};
use umwelt_core::identification::estimate::{Channel, LEVEL};
use umwelt_core::kinematics::Drive;
use umwelt_core::link::LinkModel;
use umwelt_core::plant::{PlantModel, Slip, SlipChannel};
use umwelt_core::settings::{Attribution, Method, PoseNoise, Prior, Settings};
use umwelt_core::task::Task;

/// Draws from the posterior among which the truth is ranked: ranks go from 0 to this.
pub const DRAWS: usize = 99;

/// Bins of a histogram of ranks; five ranks each.
pub const BINS: usize = 20;

/// Longest simulated time of a run in s: even a robot that creeps has driven its task by then.
const TIME_LIMIT: f64 = 400.0;

/// The prior that floors are drawn from: means of some percent and standard deviations about 0.1, known well enough that
/// no floor is beyond what a robot can drive on.
pub fn honest_prior() -> Prior {
    let channel = |mu: f64, mean_sd: f64, sd: f64| {
        let (k, r) = ((sd / mean_sd).powi(2), 8.0);
        NormalInverseChiSquared::new(mu, k, r, r * sd * sd).expect("constants in their domain")
    };
    Prior {
        forward: channel(-0.05, 0.05, 0.10),
        lateral: channel(0.0, 0.03, 0.05),
        turn: channel(-0.05, 0.05, 0.10),
        drift: channel(0.0, 0.1, 0.2),
    }
}

/// What one run says of one channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Verdict {
    /// Rank of the true mean among draws from the posterior, 0..=[`DRAWS`].
    pub mean_rank: usize,
    /// The same of the true standard deviation.
    pub sd_rank: usize,
    /// Whether the 90 % interval of the mean holds it.
    pub mean_held: bool,
    /// Whether the 90 % interval of the next ratio over 100 ms holds one that is drawn from the truth.
    pub next_held: bool,
}

/// The results of one run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Run {
    /// Per channel, in the order of [`Channel::ALL`].
    pub channels: [Verdict; 4],
    /// Samples that came, and how many of them lay within the interval that was predicted for each.
    pub coverage: Coverage,
}

/// The robot and its way: a camera, lag and dead time known, the whole calibration and two legs, on the network of a
/// laboratory, so that what is identified is the floor.
fn scenario(prior: Prior, slip: Slip) -> Scenario {
    let drive = Drive { lag: 0.08, dead_time: 0.04, ..Drive::default() };
    let settings = Settings {
        drive,
        noise: PoseNoise::CAMERA,
        method: Method::Bayesian,
        prior,
        attribution: Attribution::Played,
        drift: true,
        ..Settings::default()
    };
    Scenario {
        settings,
        plant: PlantModel { drive, slip, noise: PoseNoise::CAMERA, ..PlantModel::default() },
        link: LinkModel::preset("clean").expect("a preset"),
        task: Task {
            waypoints: vec![Point::new(0.5, 0.0), Point::new(0.0, 0.0)],
            ..Task::thesis()
        },
        start: Pose::default(),
        region: None,
        frame: umwelt_core::episode::FRAME,
        time_limit: TIME_LIMIT,
    }
}

/// A mean and a variance drawn from a belief.
fn drawn(belief: NormalInverseChiSquared, rng: &mut Pcg64) -> (f64, f64) {
    let chi_squared = ChiSquared::new(belief.r()).expect("positive degrees of freedom");
    let variance = belief.s() / chi_squared.sample(rng);
    let z: f64 = StandardNormal.sample(rng);
    (belief.mu() + z * (variance / belief.k()).sqrt(), variance)
}

/// One robot on a floor drawn from `prior`, with that prior as its belief, driven to the end of its task.
///
/// # Errors
/// Never with a prior under which floors can be driven on.
pub fn run(prior: Prior, seed: u64, index: usize) -> Result<Run, EpisodeError> {
    let mut rng = seeds::rng(seed, Purpose::Calibrate, index);
    let priors = [prior.forward, prior.lateral, prior.turn, prior.drift];
    // A floor that no simulation takes is drawn again: with `honest_prior` that is one in millions.
    let (truth, slip) = loop {
        let truth = priors.map(|belief| drawn(belief, &mut rng));
        let channels = truth.map(|(mean, variance)| SlipChannel::new(mean, variance.sqrt()));
        if let [Ok(forward), Ok(lateral), Ok(turn), Ok(drift)] = channels {
            break (truth, Slip { forward, lateral, turn, drift });
        }
    };
    let scenario = scenario(prior, slip);
    let controller = Controller::with(scenario.settings, Compensation::STANDARD);
    let mut recorder = CoverageRecorder::default();
    let place = [index, 0, 1];
    let (_, controller) = scenario.drive_observed(
        controller,
        seeds::seed(seed, Purpose::Calibrate, place),
        |_, _| {},
        &mut recorder,
    )?;
    let channels = std::array::from_fn(|channel| {
        let posterior = controller.belief().channel(Channel::ALL[channel]).posterior();
        let (mean, variance) = truth[channel];
        let mut verdict = Verdict::default();
        for _ in 0..DRAWS {
            let (drawn_mean, drawn_variance) = drawn(posterior, &mut rng);
            verdict.mean_rank += usize::from(drawn_mean < mean);
            verdict.sd_rank += usize::from(drawn_variance < variance);
        }
        let z: f64 = StandardNormal.sample(&mut rng);
        let next = mean + z * variance.sqrt();
        let [of_mean, of_next] = posterior.intervals(LEVEL);
        verdict.mean_held = (of_mean.0..=of_mean.1).contains(&mean);
        verdict.next_held = (of_next.0..=of_next.1).contains(&next);
        verdict
    });
    Ok(Run { channels, coverage: recorder.coverage() })
}

/// Pearson's chi-squared of ranks against the uniform distribution, of [`BINS`] - 1 degrees of freedom.
pub fn rank_statistic(ranks: impl Iterator<Item = usize>) -> f64 {
    let mut counts = [0.0; BINS];
    for rank in ranks {
        counts[rank * BINS / (DRAWS + 1)] += 1.0;
    }
    let expected = counts.iter().sum::<f64>() / BINS as f64;
    counts.iter().map(|count| (count - expected).powi(2) / expected).sum()
}
