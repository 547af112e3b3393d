//! The loop on the robot: poses in, wheel speeds out.
//!
//! [`run`] is all of it: it asks the server what to play ([`umwelt_core::exchange`]), plays it
//! ([`umwelt_core::actuation`]) on a [`Drive`], and needs no link to stop. Three parts, each with one job:
//!
//! * `robot` is pure: time, poses and answers in, wheel speeds and requests out, as the robot's side of
//!   [`umwelt_core::episode`] does it. A simulated minute and a real minute must agree.
//! * [`drive`] is the hardware: [`drive::Sim`], a simulated robot in real time, and [`drive::Pipe`], JSON lines on
//!   standard input and output.
//! * [`transport`] carries requests: over HTTP/2 to the server, or into the same process.
//!
//! All times are the robot's own monotonic [`Clock`]; no clocks of two machines are ever compared.
//!
//! Architecture invariant: only `agent` waits, only `robot` decides.
//!
//! ```no_run
//! use umwelt_agent::{Clock, Config, drive::Sim, run, transport};
//! # async fn example() -> Result<(), Box<dyn std::error::Error>> {
//! let config = Config::new("rover-7".parse()?);
//! let connect = transport::http("http://127.0.0.1:8080", config.robot.clone())?;
//! let drive = Sim::new(Default::default(), Default::default(), 1)?;
//! let report = run(config, connect, drive, Clock::start(), std::future::pending()).await?;
//! println!("{report:?}");
//! # Ok(())
//! # }
//! ```

mod agent;
mod clock;
pub mod drive;
mod epoch;
mod limits;
mod on_the_way;
mod report;
mod restraint;
mod robot;
mod throttle;
mod told;
pub mod transport;

pub use agent::{Config, run};
pub use clock::Clock;
pub use drive::Drive;
pub use report::{AgentError, Ended, Report, Status, TraceRow, TraceSink};
pub use told::{Difference, Told};
