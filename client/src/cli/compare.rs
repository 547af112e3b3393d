//! `umwelt compare`.

use super::failure::Failure;
use super::input;
use super::job::submit::Submit;
use super::output::Output;
use clap::Args;
use umwelt_api::comparison::{ComparisonKind, Request, Scenario};
use umwelt_api::{PriorId, Validate};
use umwelt_client::Client;

const SCENARIOS: &[&str] =
    &["thesis", "thesis-real", "floor-change", "link-change", "bursty", "outage", "systematic"];

/// What to compare.
#[derive(Debug, Args)]
#[command(after_help = ABOUT)]
pub(super) struct Compare {
    /// What is driven, and in which environments; thesis if nothing is said
    #[arg(long, value_parser = input::named::<Scenario>(SCENARIOS))]
    scenario: Option<Scenario>,
    /// Methods, each with all its numbers of slots or as bayesian/20 with one; all if nothing is said
    #[arg(long, value_name = "METHOD,...", value_delimiter = ',')]
    methods: Option<Vec<String>>,
    /// Trials of each method in each environment, 2 to 10000; 1000 if nothing is said
    #[arg(long, value_name = "N")]
    trials: Option<u64>,
    /// Seed of everything random: the same gives the same report
    #[arg(long, value_name = "S")]
    seed: Option<u64>,
    /// The prior of the method bayesian, as `umwelt prior list` names them; thesis if nothing is said
    #[arg(long, value_name = "NAME")]
    prior: Option<PriorId>,
    #[command(flatten)]
    submit: Submit,
    /// Do not wait for the end: what happens without --watch. Earlier versions waited without this
    #[arg(long, hide = true, conflicts_with = "watch")]
    detach: bool,
}

const ABOUT: &str = "\
Every method drives the same trials: the same packets are late for each, the same places of the floor slip. The report
says how much less (or more) `bayesian` deviates than `statistic` and how much sooner (or later) it arrives, beside what
the thesis claims; where an interval includes zero, no difference is shown.

Scenarios:
  thesis        0.9 m there and back on a hard floor, over a normal and a bad link, a robot without lag
  thesis-real   the thesis's corridor, there and back; the robot lags and its controller knows it
  floor-change  2.4 m there and back; the floor is slippery from 0.8 to 1.6 m
  link-change   the same way; the link is bad from 0.8 to 1.6 m
  bursty        the same way over bursty Wi-Fi with silences, on a hard and on a slippery floor
  outage        the same way; nothing gets through for 4 s
  systematic    the thesis's way with a robot that is not as its controller assumes

A comparison runs on the server, at low priority, one at a time, and outlives its restarts. With --watch the exit status
is 0 once it has succeeded; Ctrl-C ends the watching, not the comparison. With --json --watch each event is a line, the
comparison with its report the last one. An unknown method is refused with the names that there are.

Examples:
  umwelt compare --trials 100 --watch
  umwelt compare --methods statistic,bayesian --scenario floor-change --seed 7
  umwelt --json compare --trials 100 --watch |
    jq -r 'select(.report) | .report.claims[] | [.environment, .slots, .verdict] | @tsv'";

impl Compare {
    pub(super) async fn run(self, client: &Client, output: &mut Output) -> Result<(), Failure> {
        let request = self.request()?;
        self.submit.run::<ComparisonKind>(client, output, &request).await
    }

    fn request(&self) -> Result<Request, Failure> {
        let request = Request {
            scenario: self.scenario,
            methods: self.methods.clone(),
            trials: self.trials,
            seed: self.seed,
            prior: self.prior.as_ref().map(ToString::to_string),
        };
        request.validate().map_err(|problems| Failure::wrong_body("the comparison", &problems))?;
        Ok(request)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::COMPARISON;
    use crate::test_server::{Server, json};
    use clap::Parser;
    use hyper::StatusCode;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        compare: Compare,
    }

    fn compare(flags: &str) -> Compare {
        Line::parse_from(format!("compare {flags}").split_whitespace()).compare
    }

    #[test]
    fn flags_say_what_they_say_and_nothing_else() {
        assert_eq!(compare("").request().unwrap(), Request::default());
        let all = "--scenario bursty --methods statistic,bayesian/20 --trials 50 --seed 7 --prior wet-hall";
        let expected = Request {
            scenario: Some(Scenario::Bursty),
            methods: Some(vec!["statistic".to_owned(), "bayesian/20".to_owned()]),
            trials: Some(50),
            seed: Some(7),
            prior: Some("wet-hall".to_owned()),
        };
        assert_eq!(compare(all).request().unwrap(), expected);
    }

    #[test]
    fn every_flag_out_of_range_is_named_at_once() {
        let wrong = compare("--trials 1 --methods oracle,oracle").request();
        let Err(Failure::Wrong(text)) = wrong else { panic!("it is a wrong call") };
        assert!(text.starts_with("the comparison is wrong in 2 places"), "{text}");
        for field in ["trials is 1", "methods[1] is"] {
            assert!(text.contains(field), "{text}");
        }
    }

    /// A server may know more methods than this program.
    #[test]
    fn a_method_of_tomorrow_is_left_to_the_server() {
        assert!(compare("--methods of-tomorrow/3").request().is_ok());
    }

    #[test]
    fn every_scenario_can_be_named_and_is_described() {
        assert_eq!(SCENARIOS, Scenario::ALL.map(Scenario::name));
        assert!(SCENARIOS.iter().all(|name| ABOUT.contains(&format!("\n  {name} "))));
    }

    #[tokio::test]
    async fn nothing_waits_for_the_end_without_being_asked_to() {
        let server = Server::start(|request| async move {
            // Anything else would be a question about how far it has got.
            assert_eq!(request.method(), hyper::Method::POST);
            json(StatusCode::CREATED, COMPARISON)
        })
        .await;
        let client = Client::new(&server.url).unwrap();
        let (mut output, written) = Output::kept(false);
        compare("").run(&client, &mut output).await.unwrap();
        // As in earlier versions.
        compare("--detach").run(&client, &mut output).await.unwrap();
        let text = String::from_utf8(written.lock().unwrap().clone()).unwrap();
        let line =
            "comparison-12 waits for its turn; watch it: umwelt comparison watch comparison-12\n";
        assert_eq!(text, line.repeat(2));
        assert_eq!(server.requests(), 2);
        assert!(Line::try_parse_from(["compare", "--detach", "--watch"]).is_err());
    }
}
