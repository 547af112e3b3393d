//! A robot behind two pipes: poses as JSON lines on standard input, wheel speeds as JSON lines on standard output.
//!
//! ```text
//! {"t_s":81.30,"x_m":0.012,"y_m":-0.003,"heading_rad":0.02}            a tracker writes
//! {"hold":true}                                                        a bumper, an e-stop button: rest at once
//! {"max_speed_m_per_s":0.05}                                           a lidar field: no faster; null lifts it
//! {"t_s":81.45,"left_rad_per_s":1.2,"right_rad_per_s":1.3}             a motor driver reads
//! ```
//!
//! Speeds are written at every slot and at every change, zeros at rest: a motor driver that hears nothing for a few
//! slots should stop by itself. Lines that are no poses are reported and skipped; none of them moves the robot.

mod arrivals;
mod line;
mod output;

pub use output::Output;

use super::{Drive, DriveError};
use crate::throttle::Throttle;
use arrivals::Arrivals;
use line::{Line, Poses, Said, Splitter};
use output::{Putter, newest_line};
use std::io::{self, Read, Write};
use std::ops::ControlFlow;
use std::time::Duration;
use tokio::sync::{mpsc, oneshot};
use tracing::warn;
use umwelt_core::exchange::Observation;
use umwelt_core::geometry::{Pose, WheelSpeeds};
use umwelt_core::horizon::SLOT;
use umwelt_core::kinematics;
use umwelt_core::local::LocalLimits;

/// Most lines read ahead of the loop; a tracker that is faster has to wait.
const MAX_READ_AHEAD: usize = 64;

/// Size in bytes of the pipe to the motor driver where the system lets it be chosen: a driver that stopped reading
/// shows after two seconds of lines, not after half a minute.
const PIPE_SIZE: usize = 4096;

/// Longest time to let the last zeros out at the end.
const LAST_WRITE: Duration = Duration::from_millis(500);

/// Pause before a read is tried again on an input that someone has set to non-blocking.
const RETRY: Duration = Duration::from_millis(2);

/// A robot behind two pipes. Run it on [`Clock::host`](crate::Clock::host): its stamps are the host's.
#[derive(Debug)]
pub struct Pipe {
    output: Output,
    lines: mpsc::Receiver<Line>,
    /// Whether more input may come.
    is_open: bool,
    poses: Poses,
    known: Option<Observation>,
    limits: LocalLimits,
    arrivals: Arrivals,
    complaint: Throttle,
    putter: Option<Putter>,
    written: Option<oneshot::Receiver<()>>,
    applied: Option<WheelSpeeds>,
    next_line: f64,
}

impl Pipe {
    /// Poses from standard input, wheel speeds to standard output.
    ///
    /// # Errors
    /// Where no thread can be started.
    pub fn stdio(output: Output) -> io::Result<Self> {
        // Not every output is a pipe, and a larger one only hides a sleeping reader for longer.
        #[cfg(target_os = "linux")]
        let _ = rustix::pipe::fcntl_setpipe_size(io::stdout(), PIPE_SIZE);
        Self::new(io::stdin(), io::stdout(), output)
    }

    /// Poses from `reader`, wheel speeds to `writer`, each on a thread of its own: a reader that never ends and a
    /// writer that blocks hold up neither the loop nor its end.
    ///
    /// # Errors
    /// Where no thread can be started.
    pub fn new(
        reader: impl Read + Send + 'static,
        writer: impl Write + Send + 'static,
        output: Output,
    ) -> io::Result<Self> {
        let (to_lines, lines) = mpsc::channel(MAX_READ_AHEAD);
        let (putter, taker) = newest_line();
        let (done, written) = oneshot::channel();
        std::thread::Builder::new()
            .name("poses".into())
            .spawn(move || read_lines(reader, &to_lines))?;
        std::thread::Builder::new().name("speeds".into()).spawn(move || {
            if taker.write_to(writer).is_ok() {
                // No one may be waiting any more.
                let _ = done.send(());
            }
        })?;
        Ok(Self::over(lines, putter, written, output))
    }

    fn over(
        lines: mpsc::Receiver<Line>,
        putter: Putter,
        written: oneshot::Receiver<()>,
        output: Output,
    ) -> Self {
        Self {
            output,
            lines,
            is_open: true,
            poses: Poses::NEW,
            known: None,
            limits: LocalLimits::NONE,
            arrivals: Arrivals::new(),
            complaint: Throttle::default(),
            putter: Some(putter),
            written: Some(written),
            applied: None,
            next_line: f64::NEG_INFINITY,
        }
    }

    fn write(&mut self, now: f64, speeds: WheelSpeeds) -> Result<(), DriveError> {
        let putter = self.putter.as_mut().ok_or(DriveError::OutputClosed)?;
        // Horizons are checked for finite speeds on arrival; a line that cannot be written counts as lost.
        let line = self.output.line(now, speeds).map_err(|_| DriveError::OutputClosed)?;
        putter.put(now, line)
    }
}

impl Drive for Pipe {
    /// A line, or none where the input has ended.
    type Input = Option<Line>;

    const IS_HARDWARE: bool = true;

    fn describe(&mut self, drive: &kinematics::Drive) {
        if let Output::Twist(described) = &mut self.output {
            *described = *drive;
        }
    }

    fn begin(&mut self, now: f64) {
        self.next_line = now;
    }

    fn next(&self) -> f64 {
        self.next_line
    }

    async fn input(&mut self) -> Option<Line> {
        if self.is_open { self.lines.recv().await } else { std::future::pending().await }
    }

    fn take(&mut self, now: f64, input: Option<Line>) -> ControlFlow<()> {
        let Some(line) = input else {
            self.is_open = false;
            return ControlFlow::Break(());
        };
        let Said { hold, max_speed, pose } = self.poses.read(now, &line);
        self.limits.hold = hold.unwrap_or(self.limits.hold);
        self.limits.max_speed = max_speed.unwrap_or(self.limits.max_speed);
        match pose {
            None => {}
            Some(Ok(observation)) => {
                self.known = Some(observation);
                if let Some((complaint, unsaid)) =
                    self.arrivals.take(now, observation.taken.seconds())
                {
                    warn!(unsaid, "{complaint}");
                }
            }
            Some(Err(error)) => {
                if let Some(unsaid) = self.complaint.ask(now) {
                    warn!(unsaid, "line skipped: {error}");
                }
            }
        }
        ControlFlow::Continue(())
    }

    fn observe(&mut self, _: f64) -> Option<Observation> {
        self.known.take()
    }

    fn limits(&self) -> LocalLimits {
        self.limits
    }

    fn apply(&mut self, now: f64, speeds: WheelSpeeds) -> Result<(), DriveError> {
        let is_slot = now >= self.next_line;
        if !is_slot && self.applied == Some(speeds) {
            return Ok(());
        }
        if is_slot {
            // Slots that were slept through are over.
            let passed = ((now - self.next_line) / SLOT).floor() + 1.0;
            self.next_line += passed * SLOT;
        }
        self.applied = Some(speeds);
        self.write(now, speeds)
    }

    fn true_pose(&self) -> Option<Pose> {
        None
    }

    async fn finish(&mut self, now: f64) -> Result<(), DriveError> {
        self.write(now, WheelSpeeds::ZERO)?;
        // Without a putter the writer ends once everything is out.
        self.putter = None;
        let Some(written) = self.written.take() else { return Ok(()) };
        match tokio::time::timeout(LAST_WRITE, written).await {
            Ok(Ok(())) => Ok(()),
            Ok(Err(_)) => Err(DriveError::OutputClosed),
            Err(_) => Err(DriveError::OutputBlocked),
        }
    }
}

/// Reads lines until the end, an error, or no one who wants them.
fn read_lines(mut reader: impl Read, lines: &mpsc::Sender<Line>) {
    let (mut splitter, mut bytes) = (Splitter::default(), [0; 4096]);
    loop {
        match reader.read(&mut bytes) {
            Ok(0) => return,
            Ok(count) => {
                if !splitter.split(&bytes[..count], |line| lines.blocking_send(line).is_ok()) {
                    return;
                }
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => std::thread::sleep(RETRY),
            Err(error) => {
                warn!("standard input: {error}");
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests;
