//! Standard output: results, for people or as JSON. Nothing else writes there.
//!
//! Invariant: whatever a server says, nothing of it moves a cursor, ends a line or turns the order of what is read.

use super::failure::Failure;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::io::{self, IsTerminal, Write};
use umwelt_api::visible;

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
    pub(super) fn result<T: Serialize + DeserializeOwned>(
        &mut self,
        result: &T,
        text: impl FnOnce(&T) -> String,
    ) -> Result<(), Failure> {
        let text = if self.json {
            json(serde_json::to_string_pretty(result))?
        } else {
            people(result, text)
        };
        self.write(&text)
    }

    /// Writes one of many results: a line of JSON, or text below the last.
    pub(super) fn line<T: Serialize + DeserializeOwned>(
        &mut self,
        result: &T,
        text: impl FnOnce(&T) -> String,
    ) -> Result<(), Failure> {
        let text =
            if self.json { json(serde_json::to_string(result))? } else { people(result, text) };
        self.write(&text)
    }

    /// Writes one of many results where it is JSON; people see it on the status line.
    pub(super) fn json_line<T: Serialize + DeserializeOwned>(
        &mut self,
        result: &T,
    ) -> Result<(), Failure> {
        if self.json { self.line(result, |_| String::new()) } else { Ok(()) }
    }

    /// Writes the newest state of something: a line of JSON, or text, on a terminal in the place of all
    /// before.
    pub(super) fn picture<T: Serialize + DeserializeOwned>(
        &mut self,
        result: &T,
        text: impl FnOnce(&T) -> String,
    ) -> Result<(), Failure> {
        if self.json {
            return self.line(result, text);
        }
        let text = people(result, text);
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
    let text = text
        .map_err(|error| Failure::Failed(format!("the result cannot be said in JSON: {error}")))?;
    Ok(visible::json(&text).into_owned())
}

/// What people see of `result`: `text` of it, in which a line ends only where `text` ends one.
fn people<T: Serialize + DeserializeOwned>(result: &T, text: impl FnOnce(&T) -> String) -> String {
    let text = match shown(result) {
        Some(shown) => text(&shown),
        None => text(result),
    };
    visible::lines(&text).into_owned()
}

/// `result` with every hidden character in its texts escaped; none where there is none.
fn shown<T: Serialize + DeserializeOwned>(result: &T) -> Option<T> {
    let mut value = serde_json::to_value(result).ok()?;
    escape(&mut value).then(|| serde_json::from_value(value).ok()).flatten()
}

/// Escapes every hidden character; whether there was one.
fn escape(value: &mut Value) -> bool {
    match value {
        Value::String(text) => {
            let is_hiding = visible::first_hidden(text).is_some();
            if is_hiding {
                *text = visible::line(text).into_owned();
            }
            is_hiding
        }
        // All of them: the first that hides something is not the last.
        Value::Array(items) => items.iter_mut().fold(false, |found, item| escape(item) | found),
        Value::Object(fields) => fields.values_mut().fold(false, |found, it| escape(it) | found),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    const EVIL: &str = "\u{1b}]0;owned\u{7}\u{1b}[2J\r\nfake line\u{202e}abc\u{9b}31m\u{2028}";

    fn written(json: bool, write: impl FnOnce(&mut Output)) -> String {
        let (mut output, written) = Output::kept(json);
        write(&mut output);
        let bytes = written.lock().unwrap().clone();
        String::from_utf8(bytes).unwrap()
    }

    /// Guards against a note of a foreign prior that writes on the terminal, or a line that looks like ours.
    #[test]
    fn nothing_that_a_server_says_moves_a_cursor_or_ends_a_line() {
        let result = json!({"note": EVIL, "list": [{"name": EVIL}, "plain"]});
        let text =
            |it: &Value| format!("{}\n{}\n", it["note"], it["list"][0]["name"].as_str().unwrap());
        let ways = |json, way| {
            written(json, |output| {
                match way {
                    0 => output.result(&result, text),
                    1 => output.line(&result, text),
                    _ => output.picture(&result, text),
                }
                .unwrap();
            })
        };
        for way in 0..3 {
            let shown = ways(false, way);
            assert_eq!(shown.trim_end().lines().count(), 2, "{shown}");
            let hidden = shown.chars().find(|it| visible::is_hidden(*it) && *it != '\n');
            assert_eq!(hidden, None, "{shown}");
            assert!(shown.contains("u{1b}]0;owned") && shown.contains("u{a}fake line"), "{shown}");
        }
        for way in 0..3 {
            let shown = ways(true, way);
            assert!(shown.chars().all(|it| !visible::is_hidden(it) || it == '\n'), "{shown}");
            assert_eq!(
                serde_json::from_str::<Value>(&shown).unwrap(),
                result,
                "JSON says the same"
            );
        }
    }

    /// A report has lines of its own.
    #[test]
    fn a_report_keeps_its_lines() {
        let report = format!("# report\n\n\ttab {EVIL}");
        let shown = written(false, |output| output.result(&json!({}), |_| report).unwrap());
        assert!(shown.starts_with("# report\n\n\ttab \\u{1b}]0;"), "{shown}");
    }
}
