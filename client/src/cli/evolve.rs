//! `umwelt evolve`.

use super::failure::Failure;
use super::input;
use super::job::submit::Submit;
use super::output::Output;
use clap::Args;
use umwelt_api::evolution::{EvolutionKind, Optimizer, Preset, Request};
use umwelt_api::{EnvironmentId, PriorId, Validate};
use umwelt_client::Client;

const PRESETS: &[&str] = &["default", "thesis", "quick"];
const OPTIMIZERS: &[&str] = &["genetic", "cma-es", "empirical-bayes"];

/// What to evolve.
#[derive(Debug, Args)]
#[command(after_help = ABOUT)]
pub(super) struct Evolve {
    /// Where everything comes from that is not said: six environments, the thesis's two, or those two within seconds
    #[arg(long, value_parser = input::named::<Preset>(PRESETS))]
    preset: Option<Preset>,
    /// Simulated environments, as `umwelt environment list` names them
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    environments: Option<Vec<EnvironmentId>>,
    /// How the prior is searched for
    #[arg(long, value_parser = input::named::<Optimizer>(OPTIMIZERS))]
    optimizer: Option<Optimizer>,
    /// Individuals of a generation, 2 to 1000
    #[arg(long, value_name = "N")]
    population: Option<u64>,
    /// Generations, 1 to 1000
    #[arg(long, value_name = "N")]
    generations: Option<u64>,
    /// Trials of each individual in each environment, 1 to 100
    #[arg(long, value_name = "N")]
    trials: Option<u64>,
    /// Seed of everything random: the same gives the same champion
    #[arg(long, value_name = "S")]
    seed: Option<u64>,
    /// The fittest that go on as they are, fewer than the population; none in the thesis
    #[arg(long, value_name = "N")]
    elites: Option<u64>,
    /// Slots of 30 ms per reply; 1 is the thesis
    #[arg(long, value_name = "N")]
    slots: Option<u64>,
    /// Keep the champion as a prior of this name
    #[arg(long, value_name = "NAME")]
    prior: Option<PriorId>,
    #[command(flatten)]
    submit: Submit,
}

const ABOUT: &str = "\
An evolution runs on the server, at low priority, one at a time, and outlives its restarts. With --watch the exit
status is 0 once it has succeeded; Ctrl-C ends the watching, not the evolution. With --json --watch each event is a
line, the evolution with its report the last one.

Examples:
  umwelt evolve --preset quick --watch
  umwelt evolve --environments normal,slippery --generations 60 --seed 7 --prior wet-hall
  umwelt --json evolve --preset thesis | jq -r .evolution";

impl Evolve {
    pub(super) async fn run(self, client: &Client, output: &mut Output) -> Result<(), Failure> {
        let request = self.request()?;
        self.submit.run::<EvolutionKind>(client, output, &request).await
    }

    fn request(&self) -> Result<Request, Failure> {
        let environments = self.environments.as_ref();
        let request = Request {
            preset: self.preset,
            environments: environments.map(|names| names.iter().map(ToString::to_string).collect()),
            optimizer: self.optimizer,
            population: self.population,
            generations: self.generations,
            trials: self.trials,
            seed: self.seed,
            elites: self.elites,
            horizon_slots: self.slots,
            prior: self.prior.as_ref().map(ToString::to_string),
            ..Request::default()
        };
        request.validate().map_err(|problems| Failure::wrong_body("the evolution", &problems))?;
        Ok(request)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;
    use serde_json::Value;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        evolve: Evolve,
    }

    fn request(flags: &str) -> Result<Request, Failure> {
        Line::parse_from(format!("evolve {flags}").split_whitespace()).evolve.request()
    }

    #[test]
    fn flags_say_what_they_say_and_nothing_else() {
        assert_eq!(request("").unwrap(), Request::default());
        let all = "--preset quick --environments normal,bad-link --optimizer cma-es --population 20 --generations 5 \
                   --trials 3 --seed 7 --elites 2 --slots 4 --prior wet-hall";
        let expected = Request {
            preset: Some(Preset::Quick),
            environments: Some(vec!["normal".to_owned(), "bad-link".to_owned()]),
            optimizer: Some(Optimizer::CmaEs),
            population: Some(20),
            generations: Some(5),
            trials: Some(3),
            seed: Some(7),
            elites: Some(2),
            horizon_slots: Some(4),
            prior: Some("wet-hall".to_owned()),
            ..Request::default()
        };
        assert_eq!(request(all).unwrap(), expected);
    }

    #[test]
    fn every_flag_out_of_range_is_named_at_once() {
        let wrong = request("--population 1 --trials 0 --slots 68 --environments normal,normal");
        let Err(Failure::Wrong(text)) = wrong else { panic!("it is a wrong call") };
        assert!(text.starts_with("the evolution is wrong in 4 places"), "{text}");
        for field in ["population is 1", "trials is 0", "horizon_slots is 68", "environments[1] is"]
        {
            assert!(text.contains(field), "{text}");
        }
    }

    #[test]
    fn names_of_choices_are_those_of_the_wire() {
        let read = |name: &&str| Value::String((*name).to_owned());
        assert!(PRESETS.iter().map(read).all(|it| serde_json::from_value::<Preset>(it).is_ok()));
        assert!(
            OPTIMIZERS.iter().map(read).all(|it| serde_json::from_value::<Optimizer>(it).is_ok())
        );
    }
}
