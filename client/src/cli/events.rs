//! `umwelt events`.

use super::failure::Failure;
use super::output::Output;
use super::progress::{QUIET_WAIT, StatusLine, say, wait};
use super::quantity;
use clap::Args;
use clap::builder::PossibleValuesParser;
use futures_util::StreamExt;
use std::time::Duration;
use tokio::time::{Instant, interval_at};
use umwelt_api::RobotId;
use umwelt_api::event::{Event, Kind};
use umwelt_client::{Client, Error};

/// The names of the kinds of events.
const KINDS: &[&str] = &[
    "registered",
    "removed",
    "pose",
    "pose_set_aside",
    "pose_believed_again",
    "horizon",
    "environment",
    "task",
    "link",
    "epoch",
    "calibration_ended",
    "waypoint_reached",
    "arrived",
    "stopped",
    "resumed",
    "watch",
    "watch_over",
    "held",
    "released",
    "missed",
];

/// What to follow.
#[derive(Debug, Args)]
#[command(after_help = ABOUT)]
pub(super) struct Follow {
    /// The robot; all without
    #[arg(value_name = "ID")]
    robot: Option<RobotId>,
    /// Begin behind the event of this number, as far as the server remembers
    #[arg(long, value_name = "N")]
    after: Option<u64>,
    /// Only events of this type; again for each further one
    #[arg(long = "type", value_name = "TYPE", value_parser = PossibleValuesParser::new(KINDS))]
    kinds: Vec<String>,
}

const ABOUT: &str = "\
Ends with Ctrl-C. Where the connection breaks, it is made again and goes on behind the last event.

Examples:
  umwelt events --type arrived --type link
  umwelt --json events rover-7 --type pose | jq -r '[.taken_s, .x_m, .y_m] | @csv'";

impl Follow {
    pub(super) async fn run(self, client: &Client, output: &mut Output) -> Result<(), Failure> {
        tokio::select! {
            ended = self.follow(client, output) => ended,
            _ = tokio::signal::ctrl_c() => Ok(()),
        }
    }

    async fn follow(self, client: &Client, output: &mut Output) -> Result<(), Failure> {
        let mut events = wait(client.events(self.robot.as_ref(), self.after)).await?;
        let mut line = StatusLine::new();
        let mut last = Instant::now();
        let mut ticks = interval_at(last + QUIET_WAIT, Duration::from_secs(1));
        loop {
            let event = tokio::select! {
                event = events.next() => event,
                _ = ticks.tick() => {
                    if last.elapsed() >= QUIET_WAIT {
                        let quiet = quantity::span(last.elapsed().as_secs_f64());
                        line.show("quiet", &format!("nothing for {quiet}; Ctrl-C ends"));
                    }
                    continue;
                }
            };
            match event {
                Some(Ok(event)) if self.wants(&event.kind) => {
                    line.clear();
                    output.line(&event, describe)?;
                    last = Instant::now();
                }
                Some(Ok(_)) => {}
                Some(Err(error)) if error.is_transient() => {
                    line.clear();
                    say(&format!("interrupted, trying again: {error}"));
                }
                Some(Err(error @ Error::Protocol { .. })) => {
                    line.clear();
                    say(&error.to_string());
                }
                Some(Err(error)) => return Err(error.into()),
                None => return Err(Failure::Failed("the events have ended".to_owned())),
            }
        }
    }

    fn wants(&self, kind: &Kind) -> bool {
        // What this version does not know cannot be shown either.
        *kind != Kind::Other
            && (self.kinds.is_empty() || self.kinds.iter().any(|name| name == kind.name()))
    }
}

fn describe(event: &Event) -> String {
    let robot = quantity::or_unknown(event.robot.as_ref(), ToString::to_string);
    let details = details(&event.kind);
    format!("{:<8}  {robot:<12}  {:<19}  {details}", event.id, event.kind.name())
        .trim_end()
        .to_owned()
}

fn details(kind: &Kind) -> String {
    match kind {
        Kind::Pose(pose) | Kind::PoseSetAside(pose) => {
            format!("{}, taken at {:.3} s", quantity::pose(pose), pose.taken_s)
        }
        Kind::Horizon(horizon) => format!(
            "{} answers {}: {} slots of {} from {:.3} s",
            horizon.sequence,
            horizon.answers,
            horizon.wheel_speeds.len(),
            quantity::milliseconds(horizon.slot_s),
            horizon.start_s
        ),
        Kind::Environment(environment) => {
            let channels = &environment.channels;
            let mean = |mean| quantity::or_unknown(mean, |mean: f64| format!("{mean:.4}"));
            format!(
                "forward {}, turn {}, loop delay {}, late {}",
                mean(channels.forward.mean),
                mean(channels.turn.mean),
                quantity::or_unknown(environment.link.median_s, quantity::milliseconds),
                quantity::or_unknown(environment.link.late_probability, quantity::percent)
            )
        }
        Kind::Task(progress) => quantity::progress(progress),
        Kind::Link { state } => quantity::state(*state).to_owned(),
        Kind::Epoch { epoch } => epoch.to_string(),
        Kind::WaypointReached { leg } => format!("waypoint {}", leg + 1),
        Kind::Arrived { elapsed_s, max_deviation_m } => format!(
            "after {elapsed_s:.1} s, largest deviation {}",
            quantity::millimetres(*max_deviation_m)
        ),
        Kind::Watch(watch) => quantity::watch(watch),
        Kind::WatchOver { state } => format!("{}, the robot goes on", state.name()),
        Kind::Missed => "the server has forgotten some events before this".to_owned(),
        Kind::Registered
        | Kind::Removed
        | Kind::PoseBelievedAgain
        | Kind::CalibrationEnded
        | Kind::Stopped
        | Kind::Resumed
        | Kind::Held
        | Kind::Released
        | Kind::Other => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn event(json: &str) -> Event {
        serde_json::from_str(json).unwrap()
    }

    #[test]
    fn events_are_lines() {
        let pose = event(
            r#"{"id": 7, "robot": "rover-7", "type": "pose", "x_m": 0.1, "y_m": -0.2, "heading_rad": 1.5, "taken_s": 3.25}"#,
        );
        assert_eq!(
            describe(&pose),
            "7         rover-7       pose                 x 0.100 m, y -0.200 m, heading 1.500 rad, taken at 3.250 s"
        );
        let missed = event(r#"{"id": 8, "robot": null, "type": "missed"}"#);
        assert!(describe(&missed).starts_with("8         -             missed "));
        let stopped = event(r#"{"id": 8, "robot": "a", "type": "stopped"}"#);
        assert_eq!(describe(&stopped), "8         a             stopped");
    }

    #[test]
    fn only_the_types_asked_for_are_wanted() {
        let follow = |kinds: &[&str]| Follow {
            robot: None,
            after: None,
            kinds: kinds.iter().map(ToString::to_string).collect(),
        };
        assert!(follow(&[]).wants(&Kind::Stopped) && !follow(&[]).wants(&Kind::Other));
        assert!(follow(&["missed", "stopped"]).wants(&Kind::Stopped));
        assert!(!follow(&["missed"]).wants(&Kind::Stopped));
    }

    #[test]
    fn types_are_called_as_on_the_wire() {
        let simple = [
            "registered",
            "removed",
            "pose_believed_again",
            "calibration_ended",
            "stopped",
            "resumed",
            "held",
            "released",
            "missed",
        ];
        for name in simple {
            let event = event(&format!(r#"{{"id": 1, "robot": null, "type": "{name}"}}"#));
            assert_eq!(event.kind.name(), name);
        }
        assert!(simple.iter().all(|name| KINDS.contains(name)));
        assert_eq!(KINDS.len(), 20);
    }
}
