//! `umwelt stop`, `umwelt resume`.

use super::failure::Failure;
use super::output::Output;
use super::progress::{say, wait};
use clap::Args;
use umwelt_api::RobotId;
use umwelt_api::stop::{Stop, StopAll};
use umwelt_client::Client;

/// One robot or all.
#[derive(Debug, Args)]
#[group(required = true, multiple = false)]
pub(super) struct Which {
    /// The robot
    #[arg(value_name = "ID")]
    robot: Option<RobotId>,
    /// All robots
    #[arg(long)]
    all: bool,
}

impl Which {
    pub(super) async fn run(
        self,
        client: &Client,
        output: &mut Output,
        stop: bool,
    ) -> Result<(), Failure> {
        match (self.robot, stop) {
            (Some(robot), true) => {
                let answer = wait(client.stop(&robot)).await?;
                warn(answer.kept);
                output.result(&answer, one)
            }
            (Some(robot), false) => output.result(&wait(client.resume(&robot)).await?, one),
            (None, true) => {
                let answer = wait(client.stop_all()).await?;
                warn(answer.kept);
                output.result(&answer, all)
            }
            (None, false) => output.result(&wait(client.resume_all()).await?, all),
        }
    }
}

/// What to do where a stop holds and is not kept.
const NOT_KEPT: &str = "warning: this stop is not on the server's disk yet: should the server restart before it is, \
                        the robots go on. Make sure of them yourself, and see the server's log";

/// Warns of a stop that would not outlive the server.
fn warn(kept: bool) {
    if !kept {
        // It may not be read; the answer says it too.
        say(NOT_KEPT);
    }
}

fn one(answer: &Stop) -> String {
    if answer.stopped {
        format!("{0} rests until resumed: umwelt resume {0}", answer.robot)
    } else {
        format!("{} goes on", answer.robot)
    }
}

fn all(answer: &StopAll) -> String {
    let robots = answer.robots;
    if answer.stopped {
        format!("all robots rest until resumed ({robots}): umwelt resume --all")
    } else {
        format!("all robots go on ({robots})")
    }
}
