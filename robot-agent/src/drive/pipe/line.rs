//! What a pose looks like on a line, and what is no pose.

use serde::{Deserialize, Deserializer};
use umwelt_client::api::Problems;
use umwelt_client::api::step::{HEADING, MAX_SPEED};
use umwelt_client::api::task::COORDINATE;
use umwelt_client::api::{Range, body};
use umwelt_core::exchange::Observation;
use umwelt_core::geometry::Pose;
use umwelt_core::time::RobotTime;

/// Longest line in bytes; four numbers of 17 digits with their names have 150.
pub(super) const MAX_LINE: usize = 1024;

/// A pose at most this far in the future, in s, was taken now: the tracker rounds its stamps.
pub(super) const FUTURE: f64 = 0.010;

/// A pose older than this in s helps no one: the controller predicts no pose farther ahead.
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
    #[error(
        "the robot holds by a line that cannot be read: {0}. Write {{\"hold\":true}}, {{\"hold\":false}} or \
         {{\"max_speed_m_per_s\":0.05}} (null for any)"
    )]
    UnreadableLimits(String),
    #[error("{field} is {value}, it must be between {min} and {max}")]
    OutOfRange { field: &'static str, value: f64, min: f64, max: f64 },
    #[error("t_s is {by} s in the future: use the clock of this host, Python's time.monotonic()")]
    Future { by: f64 },
    #[error(
        "t_s is {by} s ago: a pose older than {TOO_OLD} s is of no use. Stamp it with this host's monotonic clock, write \
         it when it is taken and flush it"
    )]
    TooOld { by: f64 },
    #[error("t_s is {taken}, it must be later than the {newest} before it")]
    NotNewer { taken: f64, newest: f64 },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Fields {
    t_s: Option<f64>,
    #[serde(default, deserialize_with = "said")]
    x_m: Option<f64>,
    #[serde(default, deserialize_with = "said")]
    y_m: Option<f64>,
    #[serde(default, deserialize_with = "said")]
    heading_rad: Option<f64>,
    #[serde(default, deserialize_with = "said")]
    hold: Option<bool>,
    #[serde(default, deserialize_with = "said")]
    max_speed_m_per_s: Option<Option<f64>>,
}

/// A field that is there: null counts as what the type makes of it, not as a field that is missing.
fn said<'de, D: Deserializer<'de>, T: Deserialize<'de>>(field: D) -> Result<Option<T>, D::Error> {
    T::deserialize(field).map(Some)
}

/// What a line says.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Said {
    /// Whether the robot holds from now on, where the line says so.
    pub hold: Option<bool>,
    /// The speed in m/s that it allows from now on, where the line says so; none inside for any.
    pub max_speed: Option<Option<f64>>,
    /// The pose, where there is one, or what is wrong with the line.
    pub pose: Option<Result<Observation, LineError>>,
}

/// Reads lines; stamps of poses strictly increase.
#[derive(Clone, Copy, Debug)]
pub(super) struct Poses {
    newest: f64,
}

impl Poses {
    pub(super) const NEW: Self = Self { newest: f64::NEG_INFINITY };

    /// What `line` says, which arrives at `now`.
    ///
    /// A hold is obeyed whatever the pose beside it. A line that names it or a speed and cannot be read is a hold: whoever
    /// wrote it meant to restrain the robot.
    pub(super) fn read(&mut self, now: f64, line: &Line) -> Said {
        let wrong = |hold, error| Said { hold, max_speed: None, pose: Some(Err(error)) };
        let Line::Whole(line) = line else { return wrong(None, LineError::TooLong) };
        let fields: Fields = match body::parse(line) {
            Ok(fields) => fields,
            Err(found) if names_limits(line) => {
                return wrong(Some(true), LineError::UnreadableLimits(in_words(&found)));
            }
            Err(found) => return wrong(None, LineError::Malformed(in_words(&found))),
        };
        if let Some(Some(value)) = fields.max_speed_m_per_s
            && let Err(error) = in_range("max_speed_m_per_s", value, MAX_SPEED)
        {
            return wrong(Some(true), error);
        }
        let Fields { x_m, y_m, heading_rad, hold, max_speed_m_per_s: max_speed, .. } = fields;
        let is_pose = x_m.is_some() || y_m.is_some() || heading_rad.is_some();
        let is_all = !is_pose && (hold.is_some() || max_speed.is_some());
        Said { hold, max_speed, pose: (!is_all).then(|| self.pose(now, &fields)) }
    }

    /// The pose among `fields`. One that is refused changes nothing.
    fn pose(&mut self, now: f64, fields: &Fields) -> Result<Observation, LineError> {
        let there = |field: &str, value: Option<f64>| {
            value.ok_or_else(|| LineError::Malformed(format!("{field} is missing")))
        };
        let x = there("x_m", fields.x_m)?;
        let y = there("y_m", fields.y_m)?;
        let heading = there("heading_rad", fields.heading_rad)?;
        in_range("x_m", x, COORDINATE)?;
        in_range("y_m", y, COORDINATE)?;
        in_range("heading_rad", heading, HEADING)?;
        let taken = fields.t_s.unwrap_or(now);
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
        Ok(Observation { pose: Pose::new(x, y, heading), taken: RobotTime::new(taken) })
    }
}

fn in_range(field: &'static str, value: f64, range: Range) -> Result<(), LineError> {
    let (min, max) = (range.min, range.max);
    if range.contains(value) {
        Ok(())
    } else {
        Err(LineError::OutOfRange { field, value, min, max })
    }
}

/// What is wrong with a line: the field, what it holds and what to do.
fn in_words(found: &Problems) -> String {
    found.details().iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
}

/// Whether a line that cannot be read names what restrains the robot.
fn names_limits(line: &[u8]) -> bool {
    let text = String::from_utf8_lossy(line);
    ["\"hold\"", "max_speed_m_per_s"].iter().any(|name| text.contains(name))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn said(poses: &mut Poses, now: f64, text: &str) -> Said {
        poses.read(now, &Line::Whole(text.into()))
    }

    fn read(poses: &mut Poses, now: f64, text: &str) -> Result<Observation, LineError> {
        said(poses, now, text).pose.expect("a pose or an error")
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
        let expected = Observation { pose: Pose::new(1.0, -2.5, 7.0), taken: RobotTime::new(9.9) };
        assert_eq!(read(&mut poses, 10.0, stamped), Ok(expected));
        let unstamped = r#"{"x_m":1,"y_m":-2.5,"heading_rad":7}"#;
        assert_eq!(
            read(&mut poses, 10.1, unstamped),
            Ok(Observation { taken: RobotTime::new(10.1), ..expected })
        );
        let nearly = r#"{"t_s":10.205,"x_m":1,"y_m":-2.5,"heading_rad":7}"#;
        assert_eq!(
            read(&mut poses, 10.2, nearly),
            Ok(Observation { taken: RobotTime::new(10.2), ..expected })
        );
    }

    #[test]
    fn what_is_no_pose_is_named_and_changes_nothing() {
        let mut poses = Poses::NEW;
        read(&mut poses, 10.0, r#"{"t_s":9.5,"x_m":0,"y_m":0,"heading_rad":0}"#).unwrap();
        for (line, reason) in [
            ("", "empty"),
            ("hello", "it is no JSON from hello on"),
            (r#"{"x_m":0,"y_m":0}"#, "heading_rad is missing"),
            (
                r#"{"x_m":0,"y_m":0,"heading_rad":0,"z_m":1}"#,
                "z_m is 1: leave it out; known here: t_s, x_m",
            ),
            (r#"{"x_m":0,"x_m":0,"y_m":0,"heading_rad":0}"#, "x_m: it stands twice"),
            (r#"{"x_m":NaN,"y_m":0,"heading_rad":0}"#, "NaN is no number in JSON"),
            (r#"{"x_m":1e999,"y_m":0,"heading_rad":0}"#, "1e999 is beyond every number"),
            (r#"{"x_m":null,"y_m":0,"heading_rad":0}"#, "x_m: use a number, not null"),
            (r#"{"x_m":0,"y_m":0,"heading_rad":0} x"#, "it is no JSON from x on"),
            (r#"{"x_m":10001,"y_m":0,"heading_rad":0}"#, "x_m is 10001, it must be between"),
            (r#"{"t_s":10.5,"x_m":0,"y_m":0,"heading_rad":0}"#, "t_s is 0.5 s in the future"),
            (r#"{"t_s":7.5,"x_m":0,"y_m":0,"heading_rad":0}"#, "t_s is 2.5 s ago"),
            (r#"{"t_s":9.5,"x_m":0,"y_m":0,"heading_rad":0}"#, "later than the 9.5 before it"),
            (r#"{"t_s":9.0,"x_m":0,"y_m":0,"heading_rad":0}"#, "later than the 9.5 before it"),
        ] {
            let error = read(&mut poses, 10.0, line).unwrap_err().to_string();
            assert!(error.contains(reason), "{line}: {error}");
        }
        assert_eq!(poses.read(10.0, &Line::TooLong).pose, Some(Err(LineError::TooLong)));
        assert!(read(&mut poses, 10.0, r#"{"t_s":9.6,"x_m":0,"y_m":0,"heading_rad":0}"#).is_ok());
    }

    #[test]
    fn a_line_may_restrain_the_robot_with_a_pose_and_without() {
        let mut poses = Poses::NEW;
        let only = |hold, max_speed| Said { hold, max_speed, pose: None };
        for (line, expected) in [
            (r#"{"hold":true}"#, only(Some(true), None)),
            (r#"{"hold":false,"t_s":10.0}"#, only(Some(false), None)),
            (r#"{"max_speed_m_per_s":0.05}"#, only(None, Some(Some(0.05)))),
            (r#"{"max_speed_m_per_s":null,"hold":false}"#, only(Some(false), Some(None))),
        ] {
            assert_eq!(said(&mut poses, 10.0, line), expected, "{line}");
        }
        let both = said(&mut poses, 10.0, r#"{"x_m":1,"y_m":0,"heading_rad":0,"hold":true}"#);
        assert_eq!(both.hold, Some(true));
        assert_eq!(both.pose.unwrap().unwrap().pose.x, 1.0);
        // Whatever is wrong with the pose beside it.
        for pose in [r#""x_m":1e9,"y_m":0,"heading_rad":0"#, r#""x_m":1"#] {
            let said = said(&mut poses, 11.0, &format!("{{\"hold\":true,{pose}}}"));
            assert!(said.hold == Some(true) && said.pose.unwrap().is_err());
        }
    }

    #[test]
    fn a_line_that_means_to_restrain_the_robot_and_cannot_be_read_is_a_hold() {
        let mut poses = Poses::NEW;
        for line in [
            r#"{"hold":"yes"}"#,
            r#"{"hold":1}"#,
            r#"{"hold":null}"#,
            r#"{"hold":false,"z_m":1}"#,
            r#"{"hold":true"#,
            r#"{"max_speed_m_per_s":-0.1}"#,
            r#"{"max_speed_m_per_s":"slow"}"#,
            r#"{"max_speed_m_per_s":1e3}"#,
        ] {
            let said = said(&mut poses, 10.0, line);
            assert_eq!((said.hold, said.max_speed), (Some(true), None), "{line}");
            let error = said.pose.unwrap().unwrap_err().to_string();
            assert!(error.contains("hold") || error.contains("max_speed_m_per_s is"), "{error}");
        }
        assert_eq!(said(&mut poses, 10.0, "{}").hold, None);
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
                if let Some(Ok(Observation { pose, taken })) = poses.read(10.0, &line).pose {
                    prop_assert!(COORDINATE.contains(pose.x) && COORDINATE.contains(pose.y));
                    prop_assert!(pose.heading.radians().is_finite());
                    let taken = taken.seconds();
                    prop_assert!((8.0..=10.0).contains(&taken) && taken > newest);
                    newest = taken;
                }
            }
        }
    }
}
