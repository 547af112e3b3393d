//! How far a job has got, on standard error: a bar on a terminal, a line now and then elsewhere.

use crate::evaluator::Meter;
use crate::pool::remaining;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{IsTerminal, Write};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How often a bar moves.
const BAR: Duration = Duration::from_millis(100);

/// How often a line is written where there is no terminal: a log is to be read, not to be filled.
const LINE: Duration = Duration::from_secs(2);

/// Shows how far a job has got.
pub(super) struct Progress {
    /// None where there is no terminal.
    bar: Option<ProgressBar>,
    shown: Mutex<Shown>,
    begin: Instant,
}

/// What is known between two batches.
#[derive(Clone, Default)]
struct Shown {
    stage: String,
    total: u64,
}

impl Progress {
    /// Of a job that has not begun: what it does first, and how many episodes there are.
    pub(super) fn begin(stage: String, total: u64) -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let template = "{msg} {wide_bar} {pos}/{len} episodes, {elapsed} + {eta}";
            let style = ProgressStyle::with_template(template);
            ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(10))
                .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        });
        let progress = Self { bar, shown: Mutex::default(), begin: Instant::now() };
        progress.say(stage, total);
        progress
    }

    /// Takes in where it stands between two batches.
    pub(super) fn say(&self, stage: String, total: u64) {
        if let Some(bar) = &self.bar {
            bar.set_length(total);
            bar.set_message(stage.clone());
        }
        *self.shown.lock().unwrap_or_else(PoisonError::into_inner) = Shown { stage, total };
    }

    /// Does `work` and shows meanwhile what the meter says.
    pub(super) fn follow<T>(&self, meter: &Meter, work: impl FnOnce() -> T) -> T {
        std::thread::scope(|scope| {
            let (working, done) = mpsc::channel::<()>();
            scope.spawn(move || {
                let every = if self.bar.is_some() { BAR } else { LINE };
                while done.recv_timeout(every) == Err(RecvTimeoutError::Timeout) {
                    self.show(meter.episodes());
                }
                if let Some(bar) = &self.bar {
                    bar.finish_and_clear();
                }
            });
            // Dropped when the work is done, even by a panic: then the other thread ends.
            let _working = working;
            work()
        })
    }

    fn show(&self, episodes: u64) {
        if let Some(bar) = &self.bar {
            bar.set_position(episodes);
            return;
        }
        let Shown { stage, total } =
            self.shown.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let elapsed = self.begin.elapsed().as_secs_f64();
        let left = remaining(elapsed, episodes, total);
        let left = left.map(|left| format!(", {left:.0} s left")).unwrap_or_default();
        // It may not be read; the job goes on.
        let _ = writeln!(
            std::io::stderr(),
            "{stage}; {episodes} of {total} episodes in {elapsed:.0} s{left}"
        );
    }
}
