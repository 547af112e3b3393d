//! What moves: a simulated robot, or a real one behind standard input and output.

mod pipe;
mod sim;

pub use pipe::{Output, Pipe};
pub use sim::Sim;

use std::ops::ControlFlow;
use umwelt_core::exchange::Observation;
use umwelt_core::geometry::{Pose, WheelSpeeds};
use umwelt_core::kinematics;
use umwelt_core::local::LocalLimits;

/// Poses out, wheel speeds in. Times are robot time in s and never go back.
pub trait Drive: Send {
    /// What comes from outside at its own time.
    type Input: Send;

    /// Whether something real moves, which must never be left moving for ever.
    const IS_HARDWARE: bool;

    /// The server has this drive for it: before anything moves, and where it is described anew.
    fn describe(&mut self, drive: &kinematics::Drive) {
        let _ = drive;
    }

    /// The run begins at `now`, at rest.
    fn begin(&mut self, now: f64);

    /// The next robot time at which the drive has something to do by itself.
    fn next(&self) -> f64;

    /// Waits for the next input, without loss where the wait is given up.
    fn input(&mut self) -> impl Future<Output = Self::Input> + Send;

    /// Takes in an input; a break where no more poses will come.
    fn take(&mut self, now: f64, input: Self::Input) -> ControlFlow<()>;

    /// The next pose that has become known by `now`; call it until there is none.
    /// Time passes up to `now` under the speeds that were applied last.
    fn observe(&mut self, now: f64) -> Option<Observation>;

    /// What the robot itself allows now: a bumper, a lidar field, an e-stop button. It holds whatever the server says.
    fn limits(&self) -> LocalLimits {
        LocalLimits::NONE
    }

    /// Applies `speeds` from `now` on. Called at every moment, after [`Drive::observe`].
    ///
    /// # Errors
    /// Where the speeds do not get to the wheels.
    fn apply(&mut self, now: f64, speeds: WheelSpeeds) -> Result<(), DriveError>;

    /// Where the robot truly is, where that is known.
    fn true_pose(&self) -> Option<Pose>;

    /// The run has ended at `now`, at rest: a last zero, and time to let it out.
    ///
    /// # Errors
    /// Where the speeds did not get to the wheels.
    fn finish(&mut self, now: f64) -> impl Future<Output = Result<(), DriveError>> + Send;
}

/// Why wheel speeds do not get to the wheels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DriveError {
    /// No one reads the wheel speeds any more.
    #[error("nobody takes the wheel speeds: standard output is closed")]
    OutputClosed,
    /// The newest wheel speeds have waited too long for someone to read them.
    #[error(
        "nobody takes the wheel speeds: the newest ones have waited 0.5 s. Whatever reads standard output must read \
         every line as it comes, and act on the last one"
    )]
    OutputBlocked,
}
