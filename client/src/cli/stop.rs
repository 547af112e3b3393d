//! `umwelt stop`, `umwelt resume`.

use super::failure::Failure;
use super::output::Output;
use super::progress::wait;
use crate::client::Client;
use clap::Args;
use umwelt_api::RobotId;
use umwelt_api::stop::{Stop, StopAll};

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
            (Some(robot), true) => output.result(&wait(client.stop(&robot)).await?, one),
            (Some(robot), false) => output.result(&wait(client.resume(&robot)).await?, one),
            (None, true) => output.result(&wait(client.stop_all()).await?, all),
            (None, false) => output.result(&wait(client.resume_all()).await?, all),
        }
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
