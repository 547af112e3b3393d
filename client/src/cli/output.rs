//! Standard output: results, for people or as JSON. Nothing else writes there.

use super::failure::Failure;
use serde::Serialize;
use std::io::{self, IsTerminal, Write};

/// Where results go.
pub(super) struct Output {
    json: bool,
    terminal: bool,
    to: Box<dyn Write>,
}

impl Output {
    /// Standard output.
    pub(super) fn standard(json: bool) -> Self {
        let to = io::stdout();
        Self { json, terminal: to.is_terminal(), to: Box::new(to) }
    }

    #[cfg(test)]
    pub(super) fn nowhere() -> Self {
        Self { json: false, terminal: false, to: Box::new(io::sink()) }
    }

    /// An output, and what is written to it.
    #[cfg(test)]
    pub(super) fn kept(json: bool) -> (Self, std::sync::Arc<std::sync::Mutex<Vec<u8>>>) {
        #[derive(Clone, Default)]
        struct Kept(std::sync::Arc<std::sync::Mutex<Vec<u8>>>);
        impl Write for Kept {
            fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
                self.0.lock().unwrap().write(bytes)
            }

            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }
        let kept = Kept::default();
        (Self { json, terminal: false, to: Box::new(kept.clone()) }, kept.0)
    }

    /// Writes the one result of a command.
    pub(super) fn result<T: Serialize>(
        &mut self,
        result: &T,
        text: impl FnOnce(&T) -> String,
    ) -> Result<(), Failure> {
        let text =
            if self.json { json(serde_json::to_string_pretty(result))? } else { text(result) };
        self.write(&text)
    }

    /// Writes one of many results: a line of JSON, or text below the last.
    pub(super) fn line<T: Serialize>(
        &mut self,
        result: &T,
        text: impl FnOnce(&T) -> String,
    ) -> Result<(), Failure> {
        let text = if self.json { json(serde_json::to_string(result))? } else { text(result) };
        self.write(&text)
    }

    /// Writes one of many results where it is JSON; people see it on the status line.
    pub(super) fn json_line<T: Serialize>(&mut self, result: &T) -> Result<(), Failure> {
        if self.json { self.line(result, |_| String::new()) } else { Ok(()) }
    }

    /// Writes the newest state of something: a line of JSON, or text, on a terminal in the place of all
    /// before.
    pub(super) fn picture<T: Serialize>(
        &mut self,
        result: &T,
        text: impl FnOnce(&T) -> String,
    ) -> Result<(), Failure> {
        if self.json {
            return self.line(result, text);
        }
        let text = text(result);
        if self.terminal {
            // To the top left and away with all: lines that a narrow terminal has wrapped cannot be counted.
            self.write(&format!("\x1b[H\x1b[2J{text}"))
        } else {
            // A blank line between two in a log.
            self.write(&format!("{}\n\n", text.trim_end()))
        }
    }

    fn write(&mut self, text: &str) -> Result<(), Failure> {
        let end = if text.is_empty() || text.ends_with('\n') { "" } else { "\n" };
        write!(self.to, "{text}{end}")?;
        self.to.flush()?;
        Ok(())
    }
}

fn json(text: serde_json::Result<String>) -> Result<String, Failure> {
    text.map_err(|error| Failure::Failed(format!("the result cannot be said in JSON: {error}")))
}
