//! `umwelt identify`: dead time and lag of a drive from a recording, without a server.

mod columns;
mod drive;
mod read;
mod report;

use super::failure::Failure;
use super::input;
use super::output::Output;
use super::progress::{QUIET_WAIT, StatusLine};
use clap::Args;
use drive::Wheels;
use read::Rows;
use report::Report;
use std::path::PathBuf;
use std::time::Instant;
use umwelt_core::drive::Recording;
use umwelt_core::exchange::PoseNoise;
use umwelt_core::geometry::Twist;
use umwelt_core::time::RobotTime;

/// Fewest poses of which anything can be said.
const FEWEST_POSES: usize = 20;

const EXAMPLES: &str = "\
Columns: poses  t_s, x_m, y_m, heading_rad
         commands  t_s, linear_m_per_s, angular_rad_per_s (or linear, angular)
                   or t_s, left_rad_per_s, right_rad_per_s
One FILE has all of them, where cells may be empty, or several have some each. A command holds until the next one.

Examples:
  umwelt identify poses.csv commands.csv
  umwelt identify run.csv --drive wheel_radius_m=0.033,track_width_m=0.16
  umwelt identify run.csv --drive rover-7.json --json | jq .delay_s";

/// Identify dead time and lag of a drive from recorded poses and commands, without a server
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Identify {
    /// Recorded poses and commands as CSV, each file told by its header; - is standard input
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Wheels and track, as wheel_radius_m=0.033,track_width_m=0.16, or a description as for `umwelt robot add --file`;
    /// where commands are twists it may be left out
    #[arg(long, value_name = "DRIVE", num_args = 0..=1, default_value = "", default_missing_value = "", hide_default_value = true)]
    drive: String,
    /// Standard deviation of a recorded position
    #[arg(long, value_name = "M", default_value_t = PoseNoise::CAMERA.position, value_parser = positive)]
    position_noise: f64,
    /// Standard deviation of a recorded heading
    #[arg(long, value_name = "RAD", default_value_t = PoseNoise::CAMERA.heading, value_parser = positive)]
    heading_noise: f64,
    /// How far ahead poses are predicted to see what the numbers are worth
    #[arg(long, value_name = "S", default_value_t = 0.26, value_parser = ahead)]
    ahead: f64,
    /// Added to the times of all poses, where their clock is behind that of the commands
    #[arg(
        long,
        value_name = "S",
        default_value_t = 0.0,
        value_parser = finite,
        allow_negative_numbers = true
    )]
    shift_poses: f64,
}

impl Identify {
    pub(super) fn run(&self, output: &mut Output) -> Result<(), Failure> {
        let mut line = Waiting::new();
        let wheels = Wheels::read(&self.drive)?;
        let mut rows = Rows::default();
        for file in &self.files {
            rows.read(file, &wheels, &mut |rows| line.show(&format!("reading row {rows}")))?;
        }
        let mut recording = rows.recording(self.shift_poses);
        self.check(&recording)?;
        let noise = PoseNoise { position: self.position_noise, heading: self.heading_noise };
        let jumps = recording.leave_out_jumps(noise);
        let identified = recording.identify(noise, wheels.drive.track_width, self.ahead, |part| {
            line.show(&format!("identifying, {:.0} %", 100.0 * part));
        });
        drop(line);
        let report = Report::new(&recording, jumps, &identified);
        output.result(&report, report::text)
    }

    /// Whether there is anything to identify a drive by.
    fn check(&self, recording: &Recording) -> Result<(), Failure> {
        let Recording { poses, commands } = recording;
        let files: Vec<String> = self.files.iter().map(|file| input::name(file)).collect();
        let wrong = |text: String| Err(Failure::Wrong(format!("{}: {text}", files.join(", "))));
        if commands.is_empty() {
            return wrong(format!("no commands: {}", columns::COMMANDS));
        }
        if poses.len() < FEWEST_POSES {
            let (count, needed) = (poses.len(), columns::POSES);
            return wrong(format!("{count} poses, at least {FEWEST_POSES} are needed: {needed}"));
        }
        if commands.iter().all(|(_, twist)| *twist == Twist::ZERO) {
            return wrong("all commands are to rest: record starts and stops".to_owned());
        }
        if recording.known().is_none() {
            let ends = |first: RobotTime, last: RobotTime| {
                format!("{:.3} to {:.3} s", first.seconds(), last.seconds())
            };
            let (first, last) = (poses[0].taken, poses[poses.len() - 1].taken);
            let seen = ends(first, last);
            let said = ends(commands[0].0, commands[commands.len() - 1].0);
            return wrong(format!(
                "poses are of t_s {seen}, commands of t_s {said}: they have to overlap by more than {} s; record both by \
                 one clock, or add the difference to the poses by --shift-poses",
                umwelt_core::drive::LONGEST
            ));
        }
        Ok(())
    }
}

/// What is going on, once it takes long.
struct Waiting {
    begun: Instant,
    line: StatusLine,
}

impl Waiting {
    fn new() -> Self {
        Self { begun: Instant::now(), line: StatusLine::new() }
    }

    fn show(&mut self, text: &str) {
        if self.begun.elapsed() > QUIET_WAIT {
            self.line.show("identifying", text);
        }
    }
}

fn finite(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| "use a finite number".to_owned())
}

fn positive(text: &str) -> Result<f64, String> {
    finite(text).ok().filter(|it| *it > 0.0).ok_or_else(|| "use a number above 0".to_owned())
}

/// Farther ahead nobody plans by one command's lag.
fn ahead(text: &str) -> Result<f64, String> {
    let number = positive(text).ok().filter(|it| *it <= 10.0);
    number.ok_or_else(|| "use more than 0 and at most 10 s".to_owned())
}

#[cfg(test)]
mod tests;
