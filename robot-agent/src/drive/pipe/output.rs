//! Wheel speeds as lines, and the thread that writes them: the newest line replaces those that are not written yet.
//!
//! What a motor driver has not read is of no use any more once there is something newer. So the loop never waits for
//! the output and nothing piles up behind a slow reader, however many changes a burst of poses makes. A few lines may
//! wait all the same: a thread that is scheduled late then leaves no hole in a ramp. A line of which a part is written is
//! always finished first.

use crate::drive::DriveError;
use serde::Serialize;
use std::collections::VecDeque;
use std::io::{self, Write};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tokio::sync::mpsc;
use umwelt_core::geometry::WheelSpeeds;
use umwelt_core::horizon::SLOT;
use umwelt_core::kinematics::{self, MotionModel};

/// Time in s for which a line may wait to be written: beyond it the output is blocked.
pub(super) const BLOCKED: f64 = 0.5;

/// Most lines that wait: two slots and a half of a ramp, which is a line every 10 ms. One more replaces them all.
const KEPT: usize = 8;

/// Longest time in s that counts as waiting between two lines. A process that was suspended finds its writer no less
/// suspended: that time proves nothing.
const COUNTED: f64 = 2.0 * SLOT;

/// Pause before a write is tried again on an output that someone has set to non-blocking, as some shells do.
const RETRY: Duration = Duration::from_millis(2);

/// What is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Output {
    /// `left_rad_per_s` and `right_rad_per_s`.
    Wheels,
    /// `linear_m_per_s` and `angular_rad_per_s` of wheels of this drive that roll: what a base is told that makes the same
    /// wheel speeds of them.
    Twist(kinematics::Drive),
}

#[derive(Serialize)]
struct WheelsLine {
    t_s: f64,
    left_rad_per_s: f64,
    right_rad_per_s: f64,
}

#[derive(Serialize)]
struct TwistLine {
    t_s: f64,
    linear_m_per_s: f64,
    angular_rad_per_s: f64,
}

impl Output {
    /// One line, its end included. Negative zeros are written as zeros.
    pub(super) fn line(self, now: f64, speeds: WheelSpeeds) -> Result<Vec<u8>, serde_json::Error> {
        let mut line = match self {
            Self::Wheels => serde_json::to_vec(&WheelsLine {
                t_s: now,
                left_rad_per_s: speeds.left + 0.0,
                right_rad_per_s: speeds.right + 0.0,
            }),
            Self::Twist(drive) => {
                let twist = drive.wheels().forward(speeds);
                serde_json::to_vec(&TwistLine {
                    t_s: now,
                    linear_m_per_s: twist.linear + 0.0,
                    angular_rad_per_s: twist.angular + 0.0,
                })
            }
        }?;
        line.push(b'\n');
        Ok(line)
    }
}

/// The lines that are to be written next, and how many have been taken.
#[derive(Debug, Default)]
struct Waiting {
    lines: VecDeque<Vec<u8>>,
    taken: u64,
}

type Place = Arc<Mutex<Waiting>>;

/// Puts lines; a newer one replaces those that no one has taken in time.
#[derive(Debug)]
pub(super) struct Putter {
    place: Place,
    /// Says that there is a line; one word that has not been heard is enough.
    bell: mpsc::Sender<()>,
    /// Robot time in s of the last line, and for how long lines have waited by then.
    last: f64,
    waited: f64,
    /// How many had been taken then.
    taken: u64,
}

/// Takes lines; they end once the [`Putter`] is gone.
#[derive(Debug)]
pub(super) struct Taker {
    place: Place,
    bell: mpsc::Receiver<()>,
}

/// Both ends.
pub(super) fn newest_line() -> (Putter, Taker) {
    let place = Place::default();
    let (ring, bell) = mpsc::channel(1);
    let putter = Putter {
        place: Arc::clone(&place),
        bell: ring,
        last: f64::NEG_INFINITY,
        waited: 0.0,
        taken: 0,
    };
    (putter, Taker { place, bell })
}

impl Putter {
    /// Puts a line at robot time `now`. It never waits.
    ///
    /// # Errors
    /// Where no one takes lines any more, or none has been taken for [`BLOCKED`] s.
    pub(super) fn put(&mut self, now: f64, line: Vec<u8>) -> Result<(), DriveError> {
        let mut waiting = self.place.lock().unwrap_or_else(PoisonError::into_inner);
        let is_stuck = !waiting.lines.is_empty() && waiting.taken == self.taken;
        self.waited =
            if is_stuck { self.waited + (now - self.last).clamp(0.0, COUNTED) } else { 0.0 };
        (self.last, self.taken) = (now, waiting.taken);
        if waiting.lines.len() >= KEPT {
            waiting.lines.clear();
        }
        waiting.lines.push_back(line);
        drop(waiting);
        match self.bell.try_send(()) {
            Err(mpsc::error::TrySendError::Closed(())) => Err(DriveError::OutputClosed),
            _ if self.waited >= BLOCKED => Err(DriveError::OutputBlocked),
            _ => Ok(()),
        }
    }
}

impl Taker {
    fn take(&self) -> Option<Vec<u8>> {
        let mut waiting = self.place.lock().unwrap_or_else(PoisonError::into_inner);
        let line = waiting.lines.pop_front()?;
        waiting.taken += 1;
        Some(line)
    }

    /// The next line, when it comes.
    #[cfg(test)]
    pub(super) async fn next(&mut self) -> Option<Vec<u8>> {
        loop {
            if let Some(line) = self.take() {
                return Some(line);
            }
            self.bell.recv().await?;
        }
    }

    /// Writes each line at once, until there are no more or no one reads them.
    ///
    /// # Errors
    /// What the writer says.
    pub(super) fn write_to(mut self, mut writer: impl Write) -> io::Result<()> {
        loop {
            while let Some(line) = self.take() {
                write_whole(&mut writer, &line)?;
            }
            if self.bell.blocking_recv().is_none() {
                return Ok(());
            }
        }
    }
}

/// Writes all of `line`, also where the writer would rather not wait.
fn write_whole(writer: &mut impl Write, line: &[u8]) -> io::Result<()> {
    let mut rest = line;
    loop {
        let written = if rest.is_empty() {
            writer.flush().map(|()| 0)
        } else {
            match writer.write(rest) {
                Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
                written => written,
            }
        };
        match written {
            Ok(_) if rest.is_empty() => return Ok(()),
            Ok(count) => rest = &rest[count..],
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => std::thread::sleep(RETRY),
            Err(error) => return Err(error),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Takes a few bytes at a time, and every other time none.
    #[derive(Default)]
    struct Reluctant {
        taken: Vec<u8>,
        calls: u32,
    }

    impl Write for Reluctant {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.calls += 1;
            match self.calls % 3 {
                0 => Err(io::ErrorKind::WouldBlock.into()),
                1 => Err(io::ErrorKind::Interrupted.into()),
                _ => {
                    let count = bytes.len().min(7);
                    self.taken.extend_from_slice(&bytes[..count]);
                    Ok(count)
                }
            }
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_line_is_written_whole_whatever_the_writer_takes_at_a_time() {
        let mut writer = Reluctant::default();
        write_whole(&mut writer, b"a line of some length\n").unwrap();
        write_whole(&mut writer, b"and another\n").unwrap();
        assert_eq!(writer.taken, b"a line of some length\nand another\n");
    }

    #[tokio::test]
    async fn the_newest_line_replaces_those_that_no_one_took_in_time() {
        let (mut putter, mut taker) = newest_line();
        for line in ["one", "two"] {
            putter.put(0.0, line.into()).unwrap();
        }
        assert_eq!(taker.next().await.as_deref(), Some(b"one".as_slice()));
        for _ in 0..KEPT - 1 {
            putter.put(0.1, "old".into()).unwrap();
        }
        putter.put(0.1, "newest".into()).unwrap();
        drop(putter);
        assert_eq!(taker.next().await.as_deref(), Some(b"newest".as_slice()));
        assert_eq!(taker.next().await, None);
    }

    /// However far behind the reader is, it gets the end, and no more than a few lines before it.
    #[tokio::test]
    async fn a_burst_leaves_a_few_lines_and_the_last_of_them_is_the_newest() {
        let (mut putter, mut taker) = newest_line();
        for number in 0..1003 {
            putter.put(0.0, format!("{number}").into()).unwrap();
        }
        drop(putter);
        let mut lines = Vec::new();
        while let Some(line) = taker.next().await {
            lines.push(String::from_utf8(line).unwrap());
        }
        assert!(
            lines.len() <= KEPT && lines.last().is_some_and(|line| line == "1002"),
            "{lines:?}"
        );
    }

    /// However many lines come in however short a time: only waiting counts.
    #[tokio::test]
    async fn blocked_is_what_has_waited_not_what_is_much() {
        let (mut putter, mut taker) = newest_line();
        for _ in 0..10_000 {
            putter.put(1.0, "burst".into()).unwrap();
        }
        putter.put(1.0 + 3600.0, "suspended for an hour".into()).unwrap();
        let mut now = 3601.0;
        while putter.put(now, "nobody reads".into()).is_ok() {
            now += SLOT;
        }
        assert!(
            (3601.0 + BLOCKED - COUNTED - SLOT..=3601.0 + BLOCKED + SLOT).contains(&now),
            "{now}"
        );
        assert_eq!(putter.put(now, "still".into()), Err(DriveError::OutputBlocked));
        assert!(taker.next().await.is_some());
        assert_eq!(putter.put(now + SLOT, "read again".into()), Ok(()));
        drop(taker);
        assert_eq!(putter.put(now + SLOT, "gone".into()), Err(DriveError::OutputClosed));
    }
}
