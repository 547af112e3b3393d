//! How the constants of [`identification::fixed`](crate::identification::fixed) are measured: in an episode on each link.

use crate::episode::{EpisodeError, Scenario};
use crate::geometry::{Point, Pose};
use crate::identification::estimate::Channel;
use crate::identification::fixed::FixedModel;
use crate::link::LinkModel;
use crate::plant::{PlantModel, Slip};
use crate::settings::{Method, PoseNoise, Settings};
use crate::task::Task;

/// Round trips of one measurement: some hundreds of samples for each channel.
pub const ROUND_TRIPS: usize = 40;

/// Measures the errors of a robot on a hard floor over `link`: the thesis's calibration and many of its round
/// trips, one slot per horizon, errors against the commands as sent, the camera's noise discounted.
///
/// # Errors
/// Where the link means nothing.
pub fn measure(link: LinkModel, round_trips: usize, seed: u64) -> Result<FixedModel, EpisodeError> {
    let settings = Settings {
        method: Method::Bayesian,
        noise: PoseNoise::CAMERA,
        slots: 1,
        ..Settings::default()
    };
    let plant = PlantModel {
        drive: settings.drive,
        slip: Slip::HARD,
        noise: PoseNoise::CAMERA,
        ..PlantModel::default()
    };
    let trip = [Point::new(0.2, 0.0), Point::new(-0.5, 0.0), Point::new(0.0, 0.0)];
    let waypoints = trip.iter().copied().cycle().take(trip.len() * round_trips).collect();
    let task = Task { waypoints, ..Task::thesis() };
    let time_limit = 100.0 * round_trips as f64;
    let start = Pose::default();
    let scenario = Scenario {
        settings,
        plant,
        link,
        task,
        start,
        region: None,
        frame: crate::episode::FRAME,
        time_limit,
    };
    let (_, controller) = scenario.run_with(seed, |_| {})?;
    Ok(Channel::ALL.map(|channel| {
        let posterior = controller.belief().channel(channel).posterior();
        (posterior.mu(), posterior.expected_variance().unwrap_or(f64::INFINITY))
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identification::fixed::{FIXED_BAD, FIXED_NORMAL};

    /// The constants are what another seed measures too: standard deviations to a factor of 1.5, means to half
    /// a standard deviation. Drift, which no method of the thesis uses, has too heavy a tail on the bad link for that.
    #[test]
    fn the_fixed_models_are_measured() {
        for (link, model) in [("normal", FIXED_NORMAL), ("bad", FIXED_BAD)] {
            let link = LinkModel::preset(link).expect("a preset");
            let measured = measure(link, ROUND_TRIPS, 99).expect("a valid scenario");
            for (channel, ((mean, variance), (mean_2, variance_2))) in
                Channel::ALL.iter().zip(model.iter().zip(measured)).take(3)
            {
                let sds = (variance_2 / variance).sqrt();
                assert!((0.67..1.5).contains(&sds), "{channel:?}: sd {}", variance_2.sqrt());
                let off = (mean_2 - mean).abs() / variance.sqrt();
                assert!(off < 0.5, "{channel:?}: mean {mean_2}");
            }
        }
    }
}
