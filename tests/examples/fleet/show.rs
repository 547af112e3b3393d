//! What is shown: the live table on standard error, the summary on standard output.

use crate::run::{Member, Summary};
use std::error::Error;
use std::fmt::Write as _;
use std::io::{IsTerminal, Write as _, stderr, stdout};
use std::time::Duration;
use umwelt_api::environment::{Channel, Environment};
use umwelt_api::robot::Robot;
use umwelt_client::Client;

/// Most robots that a live table has lines for.
const LINES: usize = 20;

/// Without a terminal: a line of progress this often.
const PROGRESS: Duration = Duration::from_secs(2);

/// The live table, redrawn in place on a terminal, a line of progress now and then elsewhere.
pub struct Live {
    in_place: bool,
    drawn: usize,
    last: Option<Duration>,
}

impl Live {
    pub fn new() -> Self {
        Self { in_place: stderr().is_terminal(), drawn: 0, last: None }
    }

    pub async fn draw(
        &mut self,
        client: &Client,
        members: &[Member],
        robots: &[Robot],
        elapsed: Duration,
    ) -> Result<(), Box<dyn Error>> {
        if !self.in_place || robots.len() > LINES {
            if self.last.is_none_or(|last| elapsed >= last + PROGRESS) {
                self.last = Some(elapsed);
                eprintln!("{:5.1} s  {}", elapsed.as_secs_f64(), stages(robots));
            }
            return Ok(());
        }
        let mut text = String::new();
        if self.drawn > 0 {
            write!(text, "\x1b[{}A", self.drawn)?;
        }
        writeln!(
            text,
            "\x1b[K{:9} {:8} {:11} {:>4} {:>8} {:>8} {:>8} {:>9} {:>8}   identified: forward, turn (mean +- sd)",
            "robot", "floor", "stage", "leg", "x mm", "y mm", "head deg", "dev mm", "loop ms"
        )?;
        for (member, robot) in members.iter().zip(robots) {
            let environment = client.environment(&member.robot).await?;
            writeln!(text, "\x1b[K{}", row(member, robot, &environment))?;
        }
        self.drawn = robots.len() + 1;
        stderr().write_all(text.as_bytes())?;
        Ok(())
    }
}

/// How many robots are at each stage.
fn stages(robots: &[Robot]) -> String {
    let mut counts: Vec<(String, usize)> = Vec::new();
    for robot in robots {
        let stage = robot.task.as_ref().map_or("idle".to_owned(), |task| name(&task.stage));
        match counts.iter_mut().find(|(known, _)| *known == stage) {
            Some((_, count)) => *count += 1,
            None => counts.push((stage, 1)),
        }
    }
    let parts: Vec<String> =
        counts.iter().map(|(stage, count)| format!("{count} {stage}")).collect();
    parts.join(", ")
}

/// The wire name of a value.
fn name(value: &impl serde::Serialize) -> String {
    serde_json::to_value(value)
        .ok()
        .and_then(|value| value.as_str().map(str::to_owned))
        .unwrap_or_default()
}

fn row(member: &Member, robot: &Robot, environment: &Environment) -> String {
    let or_dash = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.1}"));
    let (task, pose) = (robot.task.as_ref(), robot.pose.as_ref());
    format!(
        "{:9} {:8} {:11} {:>4} {:>8} {:>8} {:>8} {:>9} {:>8}   {}  {}",
        member.robot.to_string(),
        member.floor,
        task.map_or_else(String::new, |task| name(&task.stage)),
        task.map_or_else(String::new, |task| format!("{}/{}", task.leg, task.legs)),
        or_dash(pose.map(|pose| pose.x_m * 1e3)),
        or_dash(pose.map(|pose| pose.y_m * 1e3)),
        or_dash(pose.map(|pose| pose.heading_rad.to_degrees())),
        or_dash(task.map(|task| task.deviation_m * 1e3)),
        or_dash(robot.loop_delay_median_s.map(|delay| delay * 1e3)),
        belief(&environment.channels.forward),
        belief(&environment.channels.turn),
    )
}

/// A channel's mean and standard deviation in percent.
fn belief(channel: &Channel) -> String {
    let percent = |value: Option<f64>| {
        value.map_or("  ?  ".to_owned(), |value| format!("{:5.1}", value * 100.0))
    };
    format!("{} +-{} %", percent(channel.mean), percent(channel.sd))
}

/// The summary: a table, or one JSON document.
pub fn summary(summary: &Summary, json: bool) -> Result<(), Box<dyn Error>> {
    let mut out = stdout().lock();
    if json {
        serde_json::to_writer_pretty(&mut out, summary)?;
        writeln!(out)?;
        return Ok(());
    }
    writeln!(
        out,
        "\n{} robots over the {} link, {} slots per horizon, {:.0} s of wall time",
        summary.robots.len(),
        summary.link,
        summary.slots,
        summary.wall_time_s
    )?;
    writeln!(
        out,
        "{:9} {:8} {:>7} {:>8} {:>9}   {:17} {:17} {:>9} {:>9}",
        "robot", "floor", "arrived", "time s", "max mm", "forward", "turn", "loop ms", "late"
    )?;
    for finish in &summary.robots {
        let link = &finish.environment.link;
        writeln!(
            out,
            "{:9} {:8} {:>7} {:>8.2} {:>9.1}   {:17} {:17} {:>9} {:>9}",
            finish.robot.to_string(),
            finish.floor,
            if finish.arrived { "yes" } else { "no" },
            finish.time_s,
            finish.max_deviation_m * 1e3,
            belief(&finish.environment.channels.forward),
            belief(&finish.environment.channels.turn),
            link.median_s.map_or("-".to_owned(), |median| format!("{:.0}", median * 1e3)),
            link.late_probability.map_or("-".to_owned(), |late| format!("{:.1} %", late * 100.0)),
        )?;
    }
    writeln!(
        out,
        "median time {:.2} s, maximum deviation: median {:.1} mm, 90 % below {:.1} mm",
        summary.median_time_s,
        summary.median_deviation_m * 1e3,
        summary.p90_deviation_m * 1e3
    )?;
    Ok(())
}
