//! Ordinary driving under the watch: the scenarios of `compare`, every method that the server offers.

use umwelt_core::controller::Controller;
use umwelt_core::episode::Scenario;
use umwelt_core::watch::Alarm;
use umwelt_lab::comparison::{Approach, ComparisonSettings};

/// What the watch said in one scenario.
#[derive(Debug, Default)]
pub struct Said {
    /// Simulated time driven, in s.
    pub driven: f64,
    /// Episodes driven, and those in which the robot arrived.
    pub episodes: u64,
    pub arrived: u64,
    /// What the robot was brought to rest for, and where: environment, method, slots, seed, time.
    pub alarms: Vec<(String, Alarm)>,
    /// What was remarked.
    pub remarks: Vec<(String, Alarm)>,
}

/// Drives `scenario` until `seconds` of simulated time are over, in each environment with each method in turn, on seeds
/// from `seed` on.
pub fn drive(scenario: &str, seconds: f64, seed: u64) -> Said {
    let settings = ComparisonSettings::scenario(scenario).expect("a scenario");
    let mut said = Said::default();
    for seed in seed.. {
        for contender in &settings.contenders {
            let is_offered = matches!(
                contender.approach,
                Approach::FixedNormal
                    | Approach::FixedBad
                    | Approach::Statistic
                    | Approach::Bayesian
            );
            for environment in settings.environments.iter().filter(|_| is_offered) {
                if said.driven >= seconds {
                    return said;
                }
                let told = contender.settings(&settings.controller);
                let episode = settings.episode(environment, told);
                let place = format!("{}, {}, seed {seed}", environment.name, contender.label());
                one(&episode, seed, &place, &mut said);
            }
        }
    }
    said
}

fn one(episode: &Scenario, seed: u64, place: &str, said: &mut Said) {
    let (mut before, mut end) = (None, 0.0);
    let driven = episode.drive(Controller::new(episode.settings), seed, |row, controller| {
        end = row.time;
        let now = controller.watch_state();
        let is_news = now.map(|(alarm, rests)| (alarm.condition(), rests))
            != before.map(|(alarm, rests): (Alarm, bool)| (alarm.condition(), rests));
        before = now;
        if let Some((alarm, rests)) = now.filter(|_| is_news) {
            let what = (format!("{place}, {:.1} s", row.time), alarm);
            if rests { said.alarms.push(what) } else { said.remarks.push(what) }
        }
    });
    let (outcome, _) = driven.expect("a valid scenario");
    said.driven += end;
    said.episodes += 1;
    said.arrived += u64::from(outcome.arrived);
}
