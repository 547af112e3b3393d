//! What a pose looks like on a line, and what is no pose.

use serde::Deserialize;
use umwelt_client::api::step::HEADING;
use umwelt_client::api::task::COORDINATE;
use umwelt_core::exchange::Observation;
use umwelt_core::geometry::Pose;

/// Longest line in bytes; four numbers of 17 digits with their names have 150.
pub(super) const MAX_LINE: usize = 1024;

/// A pose at most this far in the future, in s, was taken now: the tracker rounds its stamps.
pub(super) const FUTURE: f64 = 0.010;

/// A pose older than this in s helps nobody: the controller predicts no pose farther ahead.
pub(super) const TOO_OLD: f64 = 2.0;

/// A piece of input, as the splitter finds it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Line {
    /// A line without its end.
    Whole(Vec<u8>),
    /// A line of more than [`MAX_LINE`] bytes; they are gone.
    TooLong,
}

/// Splits bytes into lines and keeps no more than one.
#[derive(Debug, Default)]
pub(super) struct Splitter {
    line: Vec<u8>,
    is_too_long: bool,
}

impl Splitter {
    /// Takes in `bytes` and gives each line that ends in them to `each`, until it says stop.
    pub(super) fn split(&mut self, bytes: &[u8], mut each: impl FnMut(Line) -> bool) -> bool {
        for &byte in bytes {
            if byte == b'\n' {
                let line = std::mem::take(&mut self.line);
                let is_too_long = std::mem::take(&mut self.is_too_long);
                if !each(if is_too_long { Line::TooLong } else { Line::Whole(line) }) {
                    return false;
                }
            } else if self.line.len() < MAX_LINE {
                self.line.push(byte);
            } else {
                self.is_too_long = true;
            }
        }
        true
    }
}

/// Why a line is no pose that could be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(super) enum LineError {
    #[error("a line of more than {MAX_LINE} bytes")]
    TooLong,
    #[error("not a pose like {{\"t_s\":1.5,\"x_m\":0.1,\"y_m\":0,\"heading_rad\":0}}: {0}")]
    Malformed(String),
    #[error("{field} is {value}, it must be between {min} and {max}")]
    OutOfRange { field: &'static str, value: f64, min: f64, max: f64 },
    #[error("t_s is {by} s in the future: use the clock of this host, Python's time.monotonic()")]
    Future { by: f64 },
    #[error("t_s is {by} s ago: a pose older than {TOO_OLD} s is of no use")]
    TooOld { by: f64 },
    #[error("t_s is {taken}, it must be later than the {newest} before it")]
    NotNewer { taken: f64, newest: f64 },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Fields {
    t_s: Option<f64>,
    x_m: f64,
    y_m: f64,
    heading_rad: f64,
}

/// Reads poses whose stamps strictly increase.
#[derive(Clone, Copy, Debug)]
pub(super) struct Poses {
    newest: f64,
}

impl Poses {
    pub(super) const NEW: Self = Self { newest: f64::NEG_INFINITY };

    /// The pose on `line`, which arrives at `now`. A refused line changes nothing.
    pub(super) fn read(&mut self, now: f64, line: &Line) -> Result<Observation, LineError> {
        let Line::Whole(line) = line else { return Err(LineError::TooLong) };
        let Fields { t_s, x_m, y_m, heading_rad } = serde_json::from_slice(line)
            .map_err(|error| LineError::Malformed(error.to_string()))?;
        for (field, value, range) in [
            ("x_m", x_m, COORDINATE),
            ("y_m", y_m, COORDINATE),
            ("heading_rad", heading_rad, HEADING),
        ] {
            if !range.contains(value) {
                let (min, max) = (range.min, range.max);
                return Err(LineError::OutOfRange { field, value, min, max });
            }
        }
        let taken = t_s.unwrap_or(now);
        if taken > now + FUTURE {
            return Err(LineError::Future { by: taken - now });
        }
        let taken = taken.min(now);
        if taken < now - TOO_OLD {
            return Err(LineError::TooOld { by: now - taken });
        }
        let newest = self.newest;
        if taken <= newest {
            return Err(LineError::NotNewer { taken, newest });
        }
        self.newest = taken;
        Ok(Observation { pose: Pose::new(x_m, y_m, heading_rad), taken })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn read(poses: &mut Poses, now: f64, text: &str) -> Result<Observation, LineError> {
        poses.read(now, &Line::Whole(text.into()))
    }

    fn split(chunks: &[&[u8]]) -> Vec<Line> {
        let (mut splitter, mut lines) = (Splitter::default(), Vec::new());
        for chunk in chunks {
            splitter.split(chunk, |line| {
                lines.push(line);
                true
            });
        }
        lines
    }

    #[test]
    fn a_pose_is_read_with_its_stamp_or_stamped_on_arrival() {
        let mut poses = Poses::NEW;
        let stamped = r#" {"t_s": 9.9, "x_m": 1, "y_m": -2.5, "heading_rad": 7e0} "#;
        let expected = Observation { pose: Pose::new(1.0, -2.5, 7.0), taken: 9.9 };
        assert_eq!(read(&mut poses, 10.0, stamped), Ok(expected));
        let unstamped = r#"{"x_m":1,"y_m":-2.5,"heading_rad":7}"#;
        assert_eq!(read(&mut poses, 10.1, unstamped), Ok(Observation { taken: 10.1, ..expected }));
        let nearly = r#"{"t_s":10.205,"x_m":1,"y_m":-2.5,"heading_rad":7}"#;
        assert_eq!(read(&mut poses, 10.2, nearly), Ok(Observation { taken: 10.2, ..expected }));
    }

    #[test]
    fn what_is_no_pose_is_named_and_changes_nothing() {
        let mut poses = Poses::NEW;
        read(&mut poses, 10.0, r#"{"t_s":9.5,"x_m":0,"y_m":0,"heading_rad":0}"#).unwrap();
        for (line, reason) in [
            ("", "EOF while parsing"),
            ("hello", "expected value"),
            (r#"{"x_m":0,"y_m":0}"#, "missing field `heading_rad`"),
            (r#"{"x_m":0,"y_m":0,"heading_rad":0,"z_m":1}"#, "unknown field `z_m`"),
            (r#"{"x_m":0,"x_m":0,"y_m":0,"heading_rad":0}"#, "duplicate field `x_m`"),
            (r#"{"x_m":NaN,"y_m":0,"heading_rad":0}"#, "expected value"),
            (r#"{"x_m":1e999,"y_m":0,"heading_rad":0}"#, "number out of range"),
            (r#"{"x_m":null,"y_m":0,"heading_rad":0}"#, "invalid type: null"),
            (r#"{"x_m":0,"y_m":0,"heading_rad":0} x"#, "trailing characters"),
            (r#"{"x_m":10001,"y_m":0,"heading_rad":0}"#, "x_m is 10001, it must be between"),
            (r#"{"t_s":10.5,"x_m":0,"y_m":0,"heading_rad":0}"#, "t_s is 0.5 s in the future"),
            (r#"{"t_s":7.5,"x_m":0,"y_m":0,"heading_rad":0}"#, "t_s is 2.5 s ago"),
            (r#"{"t_s":9.5,"x_m":0,"y_m":0,"heading_rad":0}"#, "later than the 9.5 before it"),
            (r#"{"t_s":9.0,"x_m":0,"y_m":0,"heading_rad":0}"#, "later than the 9.5 before it"),
        ] {
            let error = read(&mut poses, 10.0, line).unwrap_err().to_string();
            assert!(error.contains(reason), "{line}: {error}");
        }
        assert_eq!(poses.read(10.0, &Line::TooLong), Err(LineError::TooLong));
        assert!(read(&mut poses, 10.0, r#"{"t_s":9.6,"x_m":0,"y_m":0,"heading_rad":0}"#).is_ok());
    }

    #[test]
    fn lines_are_cut_where_they_end_and_never_grow() {
        let line = |text: &str| Line::Whole(text.into());
        assert_eq!(split(&[b"a\nb", b"c\n\nd"]), [line("a"), line("bc"), line("")]);
        let long = vec![b'x'; MAX_LINE + 1];
        assert_eq!(split(&[&long, &long, b"\n", b"y\n"]), [Line::TooLong, line("y")]);
        assert_eq!(split(&[&long[1..], b"\n"]), [Line::Whole(long[1..].to_vec())]);
    }

    proptest! {
        /// Whatever comes: nothing panics, and every pose that is read is finite, in range, in time and in order.
        #[test]
        fn any_garbage_is_survived(chunks in prop::collection::vec(prop_oneof![
            prop::collection::vec(any::<u8>(), 0..200),
            "[-{}\"a-z_0-9.:,eE\n]{0,80}".prop_map(String::into_bytes),
            (any::<f64>(), any::<f64>(), -3.0..12.0f64).prop_map(|(x, y, t)| {
                format!("{{\"t_s\":{t},\"x_m\":{x:e},\"y_m\":{y:e},\"heading_rad\":0}}\n").into_bytes()
            }),
            (-20.0..20.0f64, 7.0..12.0f64).prop_map(|(x, t)| {
                format!("{{\"t_s\":{t},\"x_m\":{x},\"y_m\":0,\"heading_rad\":{x}}}\n").into_bytes()
            }),
        ], 0..40)) {
            let chunks: Vec<&[u8]> = chunks.iter().map(Vec::as_slice).collect();
            let (mut poses, mut newest) = (Poses::NEW, f64::NEG_INFINITY);
            for line in split(&chunks) {
                if let Ok(Observation { pose, taken }) = poses.read(10.0, &line) {
                    prop_assert!(COORDINATE.contains(pose.x) && COORDINATE.contains(pose.y));
                    prop_assert!(pose.heading.radians().is_finite());
                    prop_assert!((8.0..=10.0).contains(&taken) && taken > newest);
                    newest = taken;
                }
            }
        }
    }
}
