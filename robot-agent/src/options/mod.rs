//! The command line.

mod values;

use clap::{Args, Parser, ValueEnum};
use std::path::PathBuf;
use umwelt_agent::drive::{Output, Sim};
use umwelt_agent::transport::{self, Connect};
use umwelt_agent::{Config, Told};
use umwelt_client::api::RobotId;
use umwelt_client::{Client, Error, read_token};
use umwelt_core::exchange::PoseNoise;
use umwelt_core::geometry::Pose;
use umwelt_core::kinematics::{Drive, Kind, SkidSteer};
use umwelt_core::link::SENSOR_DELAY;
use umwelt_core::plant::{Lateness, PlantModel, Slip};
use values::{finite, link, not_negative, pose, positive, slip, trace};

const EXAMPLES: &str = "\
Examples:
  A simulated robot on a slippery floor, over a link that is late now and then:
      umwelt-agent --robot rover-7 --slip slippery --link bad --seed 1

  A real robot: a tracker that writes poses, a motor driver that reads wheel speeds
      tracker | umwelt-agent --robot rover-7 --drive pipe | motors

  Poses, one JSON object a line; t_s is when the pose was taken, on this host's monotonic clock (Python's
  time.monotonic()); without it the pose counts as taken when it arrives:
      {\"t_s\":81.30,\"x_m\":0.012,\"y_m\":-0.003,\"heading_rad\":0.02}
  Wheel speeds, at every 30 ms and at every change, zeros at rest:
      {\"t_s\":81.45,\"left_rad_per_s\":1.2,\"right_rad_per_s\":1.3}
  or with --output twist:
      {\"t_s\":81.45,\"linear_m_per_s\":0.0375,\"angular_rad_per_s\":0.03}
  Lines that are no poses are reported and skipped. At the end of the poses the robot ramps to rest. The motor
  driver must read every line as it comes and act on the last one, and stop by itself when it hears nothing for 0.3 s.
  A bumper, a lidar field, an e-stop button: the robot rests at once, or goes no faster, whatever the server says
      {\"hold\":true}
      {\"hold\":false}
      {\"max_speed_m_per_s\":0.05}
  null lifts the speed. All of it: docs/pipe.md

The robot must be registered with the server first: umwelt robot add rover-7
It stops by itself, within its acceleration limits, when the server or the link is gone, and goes on when they are
back. SIGTERM and SIGINT ramp it to rest. Logs go to standard error.

Exit status: 0 ended as told, at rest; 1 it failed; 2 the call was wrong.";

/// Drives a robot as an Umwelt server says: poses in, wheel speeds out.
#[derive(Debug, Parser)]
#[command(version, after_long_help = EXAMPLES)]
pub struct Options {
    /// Address of the server
    #[arg(
        long,
        value_name = "URL",
        env = "UMWELT_SERVER",
        default_value = "http://127.0.0.1:8080"
    )]
    server: String,

    /// File with the token of the server, where it has one; readable for the agent alone (chmod 600)
    #[arg(long, value_name = "FILE", env = "UMWELT_TOKEN_FILE")]
    token_file: Option<PathBuf>,

    /// Id of the robot, as registered with the server
    #[arg(long, value_name = "ID", env = "UMWELT_ROBOT")]
    robot: RobotId,

    /// What moves: a simulated robot, or a real one behind standard input and output
    #[arg(long, value_enum, env = "UMWELT_DRIVE", default_value_t = DriveKind::Sim)]
    drive: DriveKind,

    /// End by itself after so many seconds
    #[arg(long, value_name = "S", value_parser = positive)]
    duration: Option<f64>,

    /// What to log: error, warn, info, debug, or a list as info,umwelt_agent=debug
    #[arg(long, value_name = "FILTER", env = "UMWELT_LOG", default_value = "info")]
    pub log: String,

    #[command(flatten)]
    wheels: Wheels,

    #[command(flatten)]
    pipe: PipeOptions,

    #[command(flatten)]
    sim: SimOptions,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum DriveKind {
    Sim,
    Pipe,
}

/// The agent has wheels and limits from the server. What it is told here as well must be the same, or it does not drive.
#[derive(Debug, Args)]
#[command(next_help_heading = "Wheels and limits [default of each: what the server has]")]
struct Wheels {
    /// Radius of the wheels
    #[arg(long, value_name = "M", value_parser = positive)]
    wheel_radius: Option<f64>,

    /// Distance between the wheels
    #[arg(long, value_name = "M", value_parser = positive)]
    track_width: Option<f64>,

    /// Largest speed of a wheel
    #[arg(long, value_name = "RAD/S", value_parser = positive)]
    max_wheel_speed: Option<f64>,

    /// Largest speed
    #[arg(long, value_name = "M/S", value_parser = positive)]
    max_speed: Option<f64>,

    /// Smallest speed at which the motors turn; a step up to it is no acceleration
    #[arg(long, value_name = "M/S", value_parser = not_negative)]
    min_speed: Option<f64>,

    /// Largest angular velocity
    #[arg(long, alias = "max-angular", value_name = "RAD/S", value_parser = positive)]
    max_turn: Option<f64>,

    /// Smallest angular velocity at which the motors turn
    #[arg(long, alias = "min-angular", value_name = "RAD/S", value_parser = not_negative)]
    min_turn: Option<f64>,

    /// Largest acceleration
    #[arg(long, value_name = "M/S^2", value_parser = positive)]
    max_acceleration: Option<f64>,

    /// Largest angular acceleration
    #[arg(long, alias = "max-angular-acceleration", value_name = "RAD/S^2", value_parser = positive)]
    max_turn_acceleration: Option<f64>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "With --drive pipe")]
struct PipeOptions {
    /// What to write: the speed of each wheel, or the speed and angular velocity of the robot [default: wheels]
    #[arg(long, value_enum)]
    output: Option<OutputKind>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum OutputKind {
    Wheels,
    Twist,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "With --drive sim")]
struct SimOptions {
    /// Delay the traffic like this link, both ways: clean, normal, bad, wifi-bursty, or trace:FILE (CSV of t_s,rtt_ms)
    #[arg(long, value_name = "PRESET|trace:FILE", env = "UMWELT_LINK")]
    link: Option<String>,

    /// Seed of floor, camera and link; the same seed gives the same ones [default: 0]
    #[arg(long, env = "UMWELT_SEED")]
    seed: Option<u64>,

    /// The floor: none, hard, dusty, slippery, oily, loaded, ramp; or ratio errors as CHANNEL=MEAN:SD,... with the
    /// channels forward, lateral, turn and drift, the sd over 100 ms [default: none]
    #[arg(long, value_name = "PRESET|CHANNELS", value_parser = slip, allow_hyphen_values = true)]
    slip: Option<Slip>,

    /// Standard deviation of the camera's x and y [default: 0.0005]
    #[arg(long, alias = "noise-position", value_name = "M", value_parser = not_negative)]
    position_noise: Option<f64>,

    /// Standard deviation of the camera's heading [default: 0.003]
    #[arg(long, alias = "noise-heading", value_name = "RAD", value_parser = not_negative)]
    heading_noise: Option<f64>,

    /// Time constant with which the wheels follow [default: drawn by the seed, 0.06 to 0.16]
    #[arg(long, value_name = "S", value_parser = not_negative)]
    lag: Option<f64>,

    /// Time before the wheels begin to follow [default: drawn by the seed, 0 to 0.04]
    #[arg(long, value_name = "S", value_parser = not_negative)]
    dead_time: Option<f64>,

    /// What its wheels do: differential or skid-steer [default: as described to the server]
    #[arg(long, value_enum)]
    kind: Option<KindName>,

    /// How far its middle moves to the left per radian of turn to the left, with --kind skid-steer [default: 0]
    #[arg(long, value_name = "M/RAD", value_parser = finite, requires = "kind", allow_negative_numbers = true)]
    sideways: Option<f64>,

    /// By what part it turns more per m/s of speed, with --kind skid-steer [default: 0]
    #[arg(long, value_name = "S/M", value_parser = finite, requires = "kind", allow_negative_numbers = true)]
    turn_by_speed: Option<f64>,

    /// Where it stands at first, in m and rad [default: 0,0,0]
    #[arg(long, value_name = "X,Y,HEADING", value_parser = pose, allow_hyphen_values = true)]
    start: Option<Pose>,

    /// Write time, true pose and wheel speeds to this CSV file, at each change and at least every 30 ms
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
}

/// What the wheels of a simulated robot do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum KindName {
    Differential,
    SkidSteer,
}

impl SimOptions {
    /// What the wheels do, where that is said.
    fn kind(&self) -> Result<Option<Kind>, String> {
        let skid = SkidSteer {
            turn_by_speed: self.turn_by_speed.unwrap_or_default(),
            sideways: self.sideways.unwrap_or_default(),
        };
        match self.kind {
            Some(KindName::SkidSteer) => Ok(Some(Kind::SkidSteer(skid))),
            _ if self.sideways.is_some() || self.turn_by_speed.is_some() => {
                Err("--sideways and --turn-by-speed go with --kind skid-steer only".to_owned())
            }
            kind => Ok(kind.map(|_| Kind::Differential)),
        }
    }
}

/// What the command line asks for, checked.
pub struct Plan {
    pub config: Config,
    pub connect: Connect,
    pub which: Which,
}

/// What moves.
pub enum Which {
    Sim(Box<Sim>),
    Pipe(Output),
}

impl Options {
    /// Checks everything before anything moves.
    ///
    /// # Errors
    /// What is wrong with the call, in words.
    pub fn plan(self) -> Result<Plan, String> {
        self.refuse_foreign()?;
        let told = self.wheels.told()?;
        let connect = self.connect().map_err(|error| error.to_string())?;
        let mut config = Config { drive: told, duration: self.duration, ..Config::new(self.robot) };
        if self.drive == DriveKind::Pipe {
            let output = match self.pipe.output {
                None | Some(OutputKind::Wheels) => Output::Wheels,
                Some(OutputKind::Twist) => Output::Twist(told.over(Drive::default())),
            };
            return Ok(Plan { config, connect, which: Which::Pipe(output) });
        }
        let sim = self.sim;
        config.seed = sim.seed.unwrap_or_default();
        config.link = sim.link.as_deref().map(link).transpose()?;
        config.trace = sim.trace.as_deref().map(trace).transpose()?;
        let drawn = Lateness::drawn(config.seed);
        let kind = sim.kind()?;
        let model = PlantModel {
            drive: Drive {
                lag: sim.lag.unwrap_or(drawn.lag),
                dead_time: sim.dead_time.unwrap_or(drawn.dead_time),
                kind: kind.unwrap_or_default(),
                ..told.over(Drive::default())
            },
            slip: sim.slip.unwrap_or_default(),
            noise: PoseNoise {
                position: sim.position_noise.unwrap_or(PoseNoise::CAMERA.position),
                heading: sim.heading_noise.unwrap_or(PoseNoise::CAMERA.heading),
            },
            ..PlantModel::default()
        };
        let sensor_delay = config.link.as_ref().map_or(SENSOR_DELAY, |link| link.sensor_delay);
        let sim = Sim::new(model, sim.start.unwrap_or_default(), config.seed)
            .map_err(|error| error.to_string())?
            .with_sensor_delay(sensor_delay)
            .as_described()
            .with_kind(kind);
        Ok(Plan { config, connect, which: Which::Sim(Box::new(sim)) })
    }

    fn connect(&self) -> Result<Connect, Error> {
        let token = self.token_file.as_deref().map(read_token).transpose()?;
        let client = Client::authorized(&self.server, token)?;
        Ok(transport::of_client(client, self.robot.clone()))
    }

    /// A flag that would be without effect is a mistake.
    fn refuse_foreign(&self) -> Result<(), String> {
        let SimOptions {
            link,
            seed,
            slip,
            position_noise,
            heading_noise,
            lag,
            dead_time,
            kind,
            sideways: _,
            turn_by_speed: _,
            start,
            trace,
        } = &self.sim;
        let (given, wants) = match self.drive {
            DriveKind::Sim => (vec![("--output", self.pipe.output.is_some())], "pipe"),
            DriveKind::Pipe => (
                vec![
                    ("--link", link.is_some()),
                    ("--seed", seed.is_some()),
                    ("--slip", slip.is_some()),
                    ("--position-noise", position_noise.is_some()),
                    ("--heading-noise", heading_noise.is_some()),
                    ("--lag", lag.is_some()),
                    ("--dead-time", dead_time.is_some()),
                    ("--kind", kind.is_some()),
                    ("--start", start.is_some()),
                    ("--trace", trace.is_some()),
                ],
                "sim",
            ),
        };
        match given.iter().find(|(_, is_given)| *is_given) {
            Some((flag, _)) => Err(format!("{flag} goes with --drive {wants} only")),
            None => Ok(()),
        }
    }
}

impl Wheels {
    fn told(&self) -> Result<Told, String> {
        for (small, large, what) in
            [(self.min_speed, self.max_speed, "speed"), (self.min_turn, self.max_turn, "turn")]
        {
            if let (Some(small), Some(large)) = (small, large)
                && small > large
            {
                return Err(format!("--min-{what} {small} is larger than --max-{what} {large}"));
            }
        }
        Ok(Told {
            wheel_radius: self.wheel_radius,
            track_width: self.track_width,
            max_wheel_speed: self.max_wheel_speed,
            max_linear: self.max_speed,
            min_linear: self.min_speed,
            max_angular: self.max_turn,
            min_angular: self.min_turn,
            max_linear_acceleration: self.max_acceleration,
            max_angular_acceleration: self.max_turn_acceleration,
        })
    }
}

#[cfg(test)]
mod tests;
