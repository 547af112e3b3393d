//! `umwelt environment`: what is identified of a robot's. The simulated ones by name are in [`training`].

mod kind;
mod noise;
mod show;
mod wheels;

use super::failure::Failure;
use super::output::Output;
use super::progress::{QUIET_WAIT, StatusLine, wait};
use super::quantity::span;
use super::training;
use clap::Subcommand;
use show::show;
use std::time::Duration;
use tokio::time::{Instant, MissedTickBehavior, interval};
use umwelt_api::RobotId;
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

The drive follows a command after its dead time, with its lag. From poses and commands the sum of both is known well, with
whatever the stamps of the poses are late by in it; it is kept when the environment is reset. given: it is described.

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_look_takes_some_time() {
        assert_eq!(pause("0.5"), Ok(Duration::from_millis(500)));
        assert!(["0", "-1", "nan", "inf", "x"].iter().all(|text| pause(text).is_err()));
    }
}
