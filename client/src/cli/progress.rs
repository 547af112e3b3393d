//! Standard error: what goes on while one waits.

use std::io::{self, IsTerminal, Write};
use std::time::Duration;
use tokio::time::{Instant, interval_at};
use umwelt_api::visible;

/// A longer wait says what for.
pub(super) const QUIET_WAIT: Duration = Duration::from_secs(2);

/// How often a log, as opposed to a terminal, says that things are as they were.
const REPEAT: Duration = Duration::from_secs(10);

/// Writes a line to standard error, with whatever would move a cursor escaped: parts of it come from servers. Where
/// standard error is closed the line is lost.
pub(super) fn say(line: &str) {
    let _ = writeln!(io::stderr(), "{}", visible::lines(line));
}

/// The last line of standard error: replaced in place on a terminal, written again elsewhere when it changes in
/// substance or was not said for long.
pub(super) struct StatusLine {
    terminal: bool,
    shown: bool,
    said: Option<(String, Instant)>,
}

impl StatusLine {
    pub(super) fn new() -> Self {
        Self { terminal: io::stderr().is_terminal(), shown: false, said: None }
    }

    /// Shows `text`; `substance` is what of it is worth a line of its own in a log.
    pub(super) fn show(&mut self, substance: &str, text: &str) {
        if self.terminal {
            // Back to the begin of the line and away with what stood there.
            let _ = write!(io::stderr(), "\r\x1b[2K{}", visible::line(text));
            self.shown = true;
            return;
        }
        let old = self
            .said
            .as_ref()
            .is_some_and(|(said, when)| said == substance && when.elapsed() < REPEAT);
        if !old {
            say(text);
            self.said = Some((substance.to_owned(), Instant::now()));
        }
    }

    /// Removes it, so that something else can be written.
    pub(super) fn clear(&mut self) {
        if std::mem::take(&mut self.shown) {
            let _ = write!(io::stderr(), "\r\x1b[2K");
        }
    }
}

impl Drop for StatusLine {
    fn drop(&mut self) {
        self.clear();
    }
}

/// Waits for an answer; says so when it takes long.
pub(super) async fn wait<T>(answer: impl Future<Output = T>) -> T {
    let mut line = StatusLine::new();
    let begun = Instant::now();
    let mut ticks = interval_at(begun + QUIET_WAIT, Duration::from_secs(1));
    tokio::pin!(answer);
    loop {
        tokio::select! {
            answer = &mut answer => return answer,
            _ = ticks.tick() => {
                let waited = begun.elapsed().as_secs();
                line.show("waiting", &format!("waiting for the server ({waited} s)"));
            }
        }
    }
}
