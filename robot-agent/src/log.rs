//! The log, written by a thread of its own: whoever reads standard error, or stops reading it, never holds up the robot.

use std::io::{self, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::time::{Duration, Instant};

/// Most lines that wait to be written; what comes while there are as many is lost, and counted.
const MAX_WAITING: usize = 256;

/// Longest time to let the last lines out at the end.
const LAST_LINES: Duration = Duration::from_millis(500);

/// Pause before the end is asked for again.
const RETRY: Duration = Duration::from_millis(5);

enum Message {
    Line(Vec<u8>),
    /// Says when all before it is written.
    End(SyncSender<()>),
}

/// The log.
#[derive(Clone, Debug)]
pub struct Log {
    lines: SyncSender<Message>,
    lost: Arc<AtomicU64>,
}

impl Log {
    /// A log that `writer` takes.
    ///
    /// # Errors
    /// Where no thread can be started.
    pub fn start(writer: impl Write + Send + 'static) -> io::Result<Self> {
        let (lines, messages) = sync_channel(MAX_WAITING);
        let lost = Arc::<AtomicU64>::default();
        let counted = Arc::clone(&lost);
        std::thread::Builder::new()
            .name("log".into())
            .spawn(move || write_all(writer, &messages, &counted))?;
        Ok(Self { lines, lost })
    }

    /// Lets the last lines out, for as long as someone takes them.
    pub fn finish(&self) {
        let until = Instant::now() + LAST_LINES;
        let (done, all) = sync_channel(1);
        let mut end = Message::End(done);
        while let Err(TrySendError::Full(message)) = self.lines.try_send(end) {
            if Instant::now() >= until {
                return;
            }
            end = message;
            std::thread::sleep(RETRY);
        }
        // No one takes them: nothing is left to be done about it.
        let _ = all.recv_timeout(until.saturating_duration_since(Instant::now()));
    }
}

/// Each call is one line, as `tracing_subscriber` writes them.
impl Write for Log {
    fn write(&mut self, line: &[u8]) -> io::Result<usize> {
        if let Err(TrySendError::Full(_)) = self.lines.try_send(Message::Line(line.to_vec())) {
            self.lost.fetch_add(1, Ordering::Relaxed);
        }
        Ok(line.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Writes what comes. A closed standard error is no reason to end: the robot is driven without a log.
fn write_all(mut writer: impl Write, messages: &Receiver<Message>, lost: &AtomicU64) {
    for message in messages {
        match message {
            Message::Line(line) => {
                let _ = writer.write_all(&line);
            }
            Message::End(done) => {
                let _ = done.try_send(());
            }
        }
        let lost = lost.swap(0, Ordering::Relaxed);
        if lost > 0 {
            let _ = writeln!(writer, "{lost} lines of this log were lost: nobody read it in time");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    /// Takes nothing before it is let go.
    struct Stuck {
        gate: Arc<Mutex<()>>,
        taken: Arc<Mutex<Vec<u8>>>,
    }

    impl Write for Stuck {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let _open = self.gate.lock().unwrap();
            self.taken.lock().unwrap().extend_from_slice(bytes);
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    /// Guards against: a terminal that is stopped with Ctrl-S, or a full pipe, stops the loop under a moving robot.
    #[test]
    fn a_log_that_no_one_reads_holds_up_nothing_and_says_what_was_lost() {
        let (gate, taken) = (Arc::<Mutex<()>>::default(), Arc::<Mutex<Vec<u8>>>::default());
        let stuck = Stuck { gate: Arc::clone(&gate), taken: Arc::clone(&taken) };
        let mut log = Log::start(stuck).unwrap();
        let closed = gate.lock().unwrap();
        for number in 0..10_000 {
            log.write_all(format!("line {number}\n").as_bytes()).unwrap();
        }
        log.finish();
        drop(closed);
        log.finish();
        let text = String::from_utf8(taken.lock().unwrap().clone()).unwrap();
        assert!(text.starts_with("line 0\n"), "{text}");
        assert!(text.contains(" lines of this log were lost"), "{text}");
        assert!(text.lines().count() < MAX_WAITING + 10);
    }
}
