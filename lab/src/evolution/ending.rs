//! The end of an evolution: with a report, or with the reason why there is none.

use super::Evolution;
use super::environment::TrainingEnvironment;
use super::episode::Evaluation;
use super::failure::{self, Failure, GENERATIONS_WITHOUT_ARRIVAL};
use super::genome::{self, Genome};
use super::report::{self, Driven, Report};
use super::settings::EvolutionSettings;
use umwelt_core::settings::Prior;

impl Evolution {
    /// Gives up after some generations in which, as before them, no robot has arrived.
    pub(super) fn give_up_without_arrivals(&mut self, generation: usize) {
        let enough = GENERATIONS_WITHOUT_ARRIVAL.min(self.settings.generations);
        if self.state.arrivals == Some(0) && generation + 1 >= enough {
            let environments = failure::names(&self.settings.environments);
            self.state.failure =
                Some(Failure::NobodyArrives { environments, episodes: self.state.episodes });
        }
    }

    /// Why the champion, whose trials are the first of the report, is of no use.
    pub(super) fn champion_fails(&self, evaluations: &[Evaluation]) -> Option<Failure> {
        let EvolutionSettings { environments, limits, report_trials, .. } = &self.settings;
        let trials = report_trials * environments.len();
        let champion = evaluations.get(..trials)?;
        let fits = |(environment, trials): (&TrainingEnvironment, &[Evaluation])| {
            trials.iter().any(|it| environment.fitness.of(limits, it) > 0.0)
        };
        if environments.iter().zip(champion.chunks_exact(*report_trials)).any(fits) {
            return None;
        }
        let arrived = champion.iter().filter(|it| it.arrived).count() as f64 / trials as f64;
        Some(Failure::ChampionFails { environments: failure::names(environments), trials, arrived })
    }

    /// Who is reported, the champion first.
    pub(super) fn reported(&self) -> [(&'static str, Prior); 4] {
        let weak = Prior::default();
        let known = |genome: &Option<Genome>| genome.as_deref().map_or(weak, genome::to_prior);
        [
            ("champion", known(&self.state.champion)),
            ("first-generation", known(&self.state.first_generation)),
            ("default", weak),
            ("flat", Prior::flat()),
        ]
    }

    /// The results of the champion and of what it has to beat.
    pub(super) fn make_report(&self, evaluations: &[Evaluation]) -> Report {
        let environments = &self.settings.environments;
        let trials = self.settings.report_trials;
        let subjects = evaluations.chunks_exact(trials * environments.len());
        let driven = self.reported().into_iter().zip(subjects).map(|((name, prior), subject)| {
            let of_environment = |(environment, trials): (usize, &[Evaluation])| {
                let trial = |it: &Evaluation| {
                    (self.normalised(environment, it), it.time, it.deviation, it.arrived)
                };
                trials.iter().map(trial).collect()
            };
            let environments = subject.chunks_exact(trials).enumerate().map(of_environment);
            Driven { name, prior, environments: environments.collect() }
        });
        report::report(environments, driven.collect())
    }
}
