//! `umwelt environment`: what is identified of a robot's. The simulated ones by name are in [`training`].

use super::failure::Failure;
use super::output::Output;
use super::progress::{QUIET_WAIT, StatusLine, wait};
use super::quantity::{UNKNOWN, milliseconds, or_unknown, percent, span};
use super::table::{Column, Table};
use super::training;
use clap::Subcommand;
use std::fmt::Write;
use std::time::Duration;
use tokio::time::{Instant, MissedTickBehavior, interval};
use umwelt_api::RobotId;
use umwelt_api::environment::{Channel, Environment, Interval, Link, Status};
use umwelt_api::robot::Method;
use umwelt_api::watch;
use umwelt_client::Client;

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Show what was learned of the floor and the link of a robot, how sure it is, and from which prior
    #[command(after_help = ABOUT)]
    Show {
        /// The robot
        #[arg(value_name = "ID")]
        robot: RobotId,
    },
    /// Show it again whenever it changes, until Ctrl-C
    #[command(after_help = ABOUT)]
    Watch {
        /// The robot
        #[arg(value_name = "ID")]
        robot: RobotId,
        /// Seconds between looks, 0.1 to 3600
        #[arg(long, value_name = "S", default_value = "1", value_parser = pause)]
        interval: Duration,
    },
    /// Forget what was learned: back to the prior
    Reset {
        /// The robot
        #[arg(value_name = "ID")]
        robot: RobotId,
    },
    #[command(flatten)]
    Simulated(training::Command),
}

pub(super) const WHICH: &str = "\
Two kinds of environments: that in which a robot is, as identified from its motion (show, watch, reset), and the
simulated ones with names, in which priors are evolved (list, describe, put, remove).

Examples:
  umwelt environment show rover-7
  umwelt environment describe slippery";

const ABOUT: &str = "\
A channel is the ratio of an error to the commanded motion: forward and lateral error per metre, heading error per
radian turned (turn) and per metre driven (drift). -0.05 forward means that the robot gets 5 % less far than commanded.
  MEAN, SD      of the ratio over 100 ms
  MEAN WITHIN   where the mean is with the given probability: narrow once there is enough to go by
  NEXT WITHIN   where the next ratio over 100 ms will be with the given probability
  WORTH         independent samples that the samples are worth
  LN EVIDENCE   natural logarithm of the probability of the samples under the prior
  STATUS        estimating, with the part of the samples that it takes until the prior no longer dominates; estimated;
                unestimated where the model is fixed; rejected where the watch has samples set aside, and for what

The loop delay is the time from a pose being taken to the reply to it reaching the robot.";

fn pause(text: &str) -> Result<Duration, String> {
    let seconds = text.parse::<f64>().ok().filter(|seconds| (0.1..=3600.0).contains(seconds));
    seconds.map(Duration::from_secs_f64).ok_or_else(|| "use 0.1 to 3600 seconds".to_owned())
}

impl Command {
    pub(super) async fn run(self, client: &Client, output: &mut Output) -> Result<(), Failure> {
        match self {
            Self::Show { robot } => {
                let environment = wait(client.environment(&robot)).await?;
                output.result(&environment, |environment| show(&robot, environment))
            }
            Self::Watch { robot, interval } => tokio::select! {
                ended = watch(client, output, &robot, interval) => ended,
                _ = tokio::signal::ctrl_c() => Ok(()),
            },
            Self::Reset { robot } => {
                let environment = wait(client.reset_environment(&robot)).await?;
                output.result(&environment, |environment| show(&robot, environment))
            }
            Self::Simulated(command) => command.run(client, output).await,
        }
    }
}

/// Shows the environment whenever it changed. A bad link or a restarting server does not end it.
async fn watch(
    client: &Client,
    output: &mut Output,
    robot: &RobotId,
    pause: Duration,
) -> Result<(), Failure> {
    let mut line = StatusLine::new();
    let mut looks = interval(pause);
    looks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut last = None;
    let mut changed = Instant::now();
    loop {
        looks.tick().await;
        match client.environment(robot).await {
            Ok(now) if last.as_ref() != Some(&now) => {
                line.clear();
                output.picture(&now, |now| show(robot, now))?;
                last = Some(now);
                changed = Instant::now();
            }
            Ok(_) if changed.elapsed() >= QUIET_WAIT => {
                let unchanged = span(changed.elapsed().as_secs_f64());
                line.show(
                    "unchanged",
                    &format!("{robot}: nothing new for {unchanged}; Ctrl-C ends"),
                );
            }
            Ok(_) => {}
            Err(error) if error.is_transient() => {
                line.show("no answer", &format!("still trying: {error}"));
            }
            Err(error) => return Err(error.into()),
        }
    }
}

fn show(robot: &RobotId, environment: &Environment) -> String {
    let level = format!("{:.0} %", 1e2 * environment.level);
    let mut text = format!(
        "{robot}: method {}, intervals hold with probability {level}\n\n",
        method(environment.method)
    );
    let mut table = Table::new([
        Column::Text("CHANNEL"),
        Column::Text("UNIT"),
        Column::Number("MEAN"),
        Column::Number("SD"),
        Column::Number("MEAN WITHIN"),
        Column::Number("NEXT WITHIN"),
        Column::Number("SAMPLES"),
        Column::Number("WORTH"),
        Column::Number("LN EVIDENCE"),
        Column::Text("STATUS"),
    ]);
    let channels = &environment.channels;
    for (name, unit, channel) in [
        ("forward", "m/m", &channels.forward),
        ("lateral", "m/m", &channels.lateral),
        ("turn", "rad/rad", &channels.turn),
        ("drift", "rad/m", &channels.drift),
    ] {
        table.row(row(name, unit, channel));
    }
    // Writing to a String cannot fail.
    let _ = write!(text, "{table}\n{}", link(&environment.link, &level));
    let prior = environment.prior.name.as_ref().map_or("the robot's own", |name| name.as_str());
    let _ = writeln!(text, "prior    {prior}: {}", environment.prior.why);
    let Environment { windows_rejected, poses_set_aside, .. } = environment;
    let _ = writeln!(
        text,
        "motion   {windows_rejected} windows without constant motion gave no sample, {poses_set_aside} poses set aside"
    );
    text
}

fn row(name: &str, unit: &str, channel: &Channel) -> [String; 10] {
    let unused = if channel.used { "" } else { " (not used)" };
    let ratio = |value: f64| format!("{value:.4}");
    let within = |interval: Interval| format!("{:.4} .. {:.4}", interval.low, interval.high);
    [
        format!("{name}{unused}"),
        unit.to_owned(),
        or_unknown(channel.mean, ratio),
        or_unknown(channel.sd, ratio),
        or_unknown(channel.mean_interval, within),
        or_unknown(channel.predictive_interval, within),
        channel.samples.to_string(),
        or_unknown(channel.effective_samples, |samples| format!("{samples:.1}")),
        or_unknown(channel.ln_evidence, |ln| format!("{ln:.1}")),
        status(channel.status, channel.estimated_fraction, channel.rejected_for),
    ]
}

/// How far an estimate has got, in a word or two.
fn status(status: Status, fraction: Option<f64>, rejected: Option<watch::State>) -> String {
    match (status, fraction, rejected) {
        (Status::Estimating, Some(fraction), _) => format!("estimating, {:.0} %", 1e2 * fraction),
        (Status::Rejected, _, Some(reason)) => format!("rejected: {}", reason.name()),
        (Status::Other, ..) => UNKNOWN.to_owned(),
        _ => status.name().to_owned(),
    }
}

fn link(link: &Link, level: &str) -> String {
    let Link { samples, late, .. } = link;
    let mut text = match (link.median_s, link.p99_s) {
        (None, _) => "link     no reply delivered yet\n".to_owned(),
        (Some(median), p99) => format!(
            "link     loop delay: median {}, 99 % of those not late within {} ({})\n",
            milliseconds(median),
            or_unknown(p99, milliseconds),
            status(link.delay_status, link.delay_estimated_fraction, None)
        ),
    };
    let probability = or_unknown(link.late_probability, percent);
    let within = link.late_interval.map_or_else(
        || UNKNOWN.to_owned(),
        |interval| format!("{} .. {}", percent(interval.low), percent(interval.high)),
    );
    let _ = writeln!(
        text,
        "late     {late} of {samples} deliveries: probability {probability}, with {level} within {within} ({})",
        status(link.late_status, link.late_estimated_fraction, None)
    );
    if let Some(note) = &link.note {
        let _ = writeln!(text, "note     {note}");
    }
    text
}

fn method(method: Method) -> &'static str {
    match method {
        Method::FixedNormal => "fixed-normal",
        Method::FixedBad => "fixed-bad",
        Method::Statistic => "statistic",
        Method::Bayesian => "bayesian",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use umwelt_api::environment::{Channels, Prior};
    use umwelt_api::prior::Source;

    fn environment() -> Environment {
        let slippery = Channel {
            used: true,
            mean: Some(-0.052),
            sd: Some(0.031),
            mean_interval: Some(Interval { low: -0.06, high: -0.044 }),
            predictive_interval: Some(Interval { low: -0.103, high: -0.001 }),
            samples: 412,
            effective_samples: Some(120.34),
            ln_evidence: Some(-33.1),
            status: Status::Estimated,
            estimated_fraction: Some(1.0),
            rejected_for: None,
        };
        let unknown = Channel {
            used: false,
            mean: Some(0.0),
            sd: None,
            mean_interval: None,
            predictive_interval: None,
            samples: 0,
            effective_samples: Some(0.0),
            ln_evidence: Some(0.0),
            status: Status::Estimating,
            estimated_fraction: Some(0.0),
            rejected_for: None,
        };
        Environment {
            method: Method::Bayesian,
            level: 0.9,
            channels: Channels {
                forward: slippery,
                lateral: slippery,
                turn: slippery,
                drift: unknown,
            },
            link: Link {
                samples: 12,
                median_s: Some(0.2124),
                p99_s: Some(0.48),
                late: 0,
                late_probability: Some(0.07),
                late_interval: Some(Interval { low: 0.004, high: 0.2 }),
                chance_of_luck: Some(0.54),
                note: Some("no late packet in 12 deliveries says little yet".to_owned()),
                delay_status: Status::Estimated,
                delay_estimated_fraction: Some(1.0),
                late_status: Status::Estimating,
                late_estimated_fraction: Some(0.2),
            },
            windows_rejected: 3,
            poses_set_aside: 1,
            prior: Prior::of("wet-hall".parse().ok(), Source::Put, Method::Bayesian),
        }
    }

    #[test]
    fn an_environment_is_shown_with_how_sure_it_is() {
        assert_eq!(show(&"a".parse().unwrap(), &environment()), "\
a: method bayesian, intervals hold with probability 90 %

CHANNEL           UNIT        MEAN      SD         MEAN WITHIN         NEXT WITHIN  SAMPLES  WORTH  LN EVIDENCE  STATUS
forward           m/m      -0.0520  0.0310  -0.0600 .. -0.0440  -0.1030 .. -0.0010      412  120.3        -33.1  estimated
lateral           m/m      -0.0520  0.0310  -0.0600 .. -0.0440  -0.1030 .. -0.0010      412  120.3        -33.1  estimated
turn              rad/rad  -0.0520  0.0310  -0.0600 .. -0.0440  -0.1030 .. -0.0010      412  120.3        -33.1  estimated
drift (not used)  rad/m     0.0000       -                   -                   -        0    0.0          0.0  estimating, 0 %

link     loop delay: median 212 ms, 99 % of those not late within 480 ms (estimated)
late     0 of 12 deliveries: probability 7.0 %, with 90 % within 0.400 % .. 20.0 % (estimating, 20 %)
note     no late packet in 12 deliveries says little yet
prior    wet-hall: the description of the robot names wet-hall, which somebody put
motion   3 windows without constant motion gave no sample, 1 poses set aside
");
    }

    #[test]
    fn nothing_known_of_the_link_is_said_so() {
        let mut environment = environment();
        environment.link.median_s = None;
        environment.link.note = None;
        environment.prior = Prior::of(None, Source::Inline, Method::Statistic);
        let text = show(&"a".parse().unwrap(), &environment);
        assert!(text.contains("prior    the robot's own: the description"), "{text}");
        assert!(text.contains("no reply delivered yet") && !text.contains("note"), "{text}");
    }

    #[test]
    fn a_status_is_shown_with_its_fraction_or_its_reason() {
        assert_eq!(status(Status::Estimating, Some(0.426), None), "estimating, 43 %");
        let stuck = Some(watch::State::Stuck);
        assert_eq!(status(Status::Rejected, None, stuck), "rejected: stuck");
        assert_eq!(status(Status::Unestimated, None, None), "unestimated");
        assert_eq!(status(Status::Other, None, None), UNKNOWN);
    }

    #[test]
    fn methods_are_called_as_on_the_wire() {
        for named in [Method::FixedNormal, Method::FixedBad, Method::Statistic, Method::Bayesian] {
            assert_eq!(serde_json::to_value(named).unwrap(), method(named));
        }
    }

    #[test]
    fn a_look_takes_some_time() {
        assert_eq!(pause("0.5"), Ok(Duration::from_millis(500)));
        assert!(["0", "-1", "nan", "inf", "x"].iter().all(|text| pause(text).is_err()));
    }
}
