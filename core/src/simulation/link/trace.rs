//! Recorded round trips: rows of time and RTT, read from CSV and repeated for ever.

use super::limits::LONGEST_DELAY;

/// The first line of a trace in CSV.
pub const TRACE_HEADER: &str = "t_s,rtt_ms";

/// Most rows of a trace: eight hours of one row per slot. More would not be read in a request's time.
pub const MAX_TRACE_ROWS: usize = 1_000_000;

/// Recorded round-trip times in s, each in force from its own time on, repeated cyclically.
///
/// The last row lasts as long as the row before it did; then the first one is in force again. One row alone is a
/// constant. Times before the first row continue the cycle backwards.
///
/// ```
/// use umwelt_core::link::RttTrace;
/// let trace = RttTrace::new(vec![(0.0, 0.02), (1.0, 0.05), (3.0, 0.01)])?;
/// assert_eq!([0.0, 0.9, 1.0, 4.9, 5.0, 6.0].map(|t| trace.at(t)), [0.02, 0.02, 0.05, 0.01, 0.02, 0.05]);
/// # Ok::<(), umwelt_core::link::TraceError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct RttTrace {
    rows: Vec<(f64, f64)>,
}

/// Why rows are no trace. Lines count from 1 with the header; rows that come without text count as if below it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TraceError {
    /// The first line is not the header.
    #[error("line {line}: the header is {found:?}, it must be \"{TRACE_HEADER}\"")]
    Header {
        /// Line number, 1.
        line: usize,
        /// What stands there, shortened.
        found: String,
    },
    /// A row has not two columns.
    #[error("line {line}: {found:?} must be two columns, {TRACE_HEADER}")]
    Columns {
        /// Line number.
        line: usize,
        /// The row, shortened.
        found: String,
    },
    /// A field is no number.
    #[error("line {line}: {column} is {found:?}, it must be a number")]
    Number {
        /// Line number.
        line: usize,
        /// Name of the column.
        column: &'static str,
        /// The field, shortened.
        found: String,
    },
    /// A value is infinite or not a number.
    #[error("line {line}: {column} is {value}, it must be finite")]
    NonFinite {
        /// Line number.
        line: usize,
        /// Name of the column.
        column: &'static str,
        /// The value as it stands in the trace.
        value: f64,
    },
    /// A time or an RTT is negative.
    #[error("line {line}: {column} is {value}, it must not be negative")]
    Negative {
        /// Line number.
        line: usize,
        /// Name of the column.
        column: &'static str,
        /// The value as it stands in the trace.
        value: f64,
    },
    /// An RTT is longer than any delay may be.
    #[error("line {line}: an RTT of {rtt} s is longer than {LONGEST_DELAY} s")]
    TooLong {
        /// Line number.
        line: usize,
        /// The RTT in s.
        rtt: f64,
    },
    /// A time is not later than the one before.
    #[error("line {line}: t_s is {value}, it must be greater than the {previous} before it")]
    NotIncreasing {
        /// Line number.
        line: usize,
        /// The time in s.
        value: f64,
        /// The time in s of the row before.
        previous: f64,
    },
    /// There is no row.
    #[error("line {line}: the trace ends without a row")]
    Empty {
        /// Number of the last line.
        line: usize,
    },
    /// There are more rows than the limit.
    #[error("line {line}: a trace has at most {MAX_TRACE_ROWS} rows")]
    TooManyRows {
        /// Line number of the first row over the limit.
        line: usize,
    },
}

impl RttTrace {
    /// The trace of rows `(time in s, RTT in s)`, times not negative and strictly increasing.
    pub fn new(rows: Vec<(f64, f64)>) -> Result<Self, TraceError> {
        let mut previous = None;
        for (index, &(time, rtt)) in rows.iter().enumerate() {
            check_row(index, index + 2, previous, time, rtt)?;
            previous = Some(time);
        }
        if rows.is_empty() { Err(TraceError::Empty { line: 1 }) } else { Ok(Self { rows }) }
    }

    /// The rows `(time in s, RTT in s)`; never empty.
    pub fn rows(&self) -> &[(f64, f64)] {
        &self.rows
    }

    /// Seconds after which the trace repeats; infinite for a single row.
    pub fn period(&self) -> f64 {
        match self.rows.as_slice() {
            [(first, _), .., (before, _), (last, _)] => 2.0 * last - before - first,
            [(first, _), (last, _)] => 2.0 * (last - first),
            _ => f64::INFINITY,
        }
    }

    /// The RTT in s that is in force at time `now` in s.
    pub fn at(&self, now: f64) -> f64 {
        let first = self.rows[0];
        if self.rows.len() == 1 {
            return first.1;
        }
        let phase = first.0 + (now - first.0).rem_euclid(self.period());
        let after = self.rows.partition_point(|row| row.0 <= phase);
        self.rows[after.max(1) - 1].1
    }
}

/// Reads a trace from CSV: the header `t_s,rtt_ms`, then a row per line. Blank lines are skipped.
///
/// ```
/// use umwelt_core::link::parse_trace;
/// assert_eq!(parse_trace("t_s,rtt_ms\n0,40\n0.5,440\n")?.at(0.7), 0.44);
/// let error = parse_trace("t_s,rtt_ms\n0,40\n0.5,-1\n").unwrap_err();
/// assert_eq!(error.to_string(), "line 3: rtt_ms is -1, it must not be negative");
/// # Ok::<(), umwelt_core::link::TraceError>(())
/// ```
pub fn parse_trace(text: &str) -> Result<RttTrace, TraceError> {
    // A byte order mark is what spreadsheets put in front; it is no part of the header.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut lines = text.lines().enumerate();
    let header = lines.next().map_or("", |(_, line)| line.trim());
    if header != TRACE_HEADER {
        return Err(TraceError::Header { line: 1, found: excerpt(header) });
    }
    let (mut rows, mut previous, mut end) = (Vec::new(), None, 1);
    for (index, text) in lines {
        let (line, row) = (index + 1, text.trim());
        end = line;
        if row.is_empty() {
            continue;
        }
        let Some((time, rtt)) = row.split_once(',').filter(|(_, rtt)| !rtt.contains(',')) else {
            return Err(TraceError::Columns { line, found: excerpt(row) });
        };
        let time = number(line, "t_s", time)?;
        let rtt_ms = number(line, "rtt_ms", rtt)?;
        check_row(rows.len(), line, previous, time, rtt_ms / 1000.0)
            .map_err(|error| in_milliseconds(error, rtt_ms))?;
        rows.push((time, rtt_ms / 1000.0));
        previous = Some(time);
    }
    if rows.is_empty() { Err(TraceError::Empty { line: end }) } else { Ok(RttTrace { rows }) }
}

fn number(line: usize, column: &'static str, field: &str) -> Result<f64, TraceError> {
    let field = field.trim();
    field.parse().map_err(|_| TraceError::Number { line, column, found: excerpt(field) })
}

/// `error` with the value as the file has it.
fn in_milliseconds(error: TraceError, rtt_ms: f64) -> TraceError {
    match error {
        TraceError::NonFinite { line, column: "rtt_s", .. } => {
            TraceError::NonFinite { line, column: "rtt_ms", value: rtt_ms }
        }
        TraceError::Negative { line, column: "rtt_s", .. } => {
            TraceError::Negative { line, column: "rtt_ms", value: rtt_ms }
        }
        other => other,
    }
}

/// Checks row number `index`, found on `line`, with its RTT in s.
fn check_row(
    index: usize,
    line: usize,
    previous: Option<f64>,
    time: f64,
    rtt: f64,
) -> Result<(), TraceError> {
    if index >= MAX_TRACE_ROWS {
        return Err(TraceError::TooManyRows { line });
    }
    for (column, value) in [("t_s", time), ("rtt_s", rtt)] {
        if !value.is_finite() {
            return Err(TraceError::NonFinite { line, column, value });
        }
        if value < 0.0 {
            return Err(TraceError::Negative { line, column, value });
        }
    }
    if rtt > LONGEST_DELAY {
        return Err(TraceError::TooLong { line, rtt });
    }
    match previous {
        Some(previous) if time <= previous => {
            Err(TraceError::NotIncreasing { line, value: time, previous })
        }
        _ => Ok(()),
    }
}

/// The first characters of outside text, for an error message.
fn excerpt(text: &str) -> String {
    text.chars().take(40).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn every_wrong_row_is_named_by_line_value_and_condition() {
        let cases = [
            ("", "line 1: the header is \"\", it must be \"t_s,rtt_ms\""),
            ("t,rtt\n0,1", "line 1: the header is \"t,rtt\", it must be \"t_s,rtt_ms\""),
            ("t_s,rtt_ms\n\n", "line 2: the trace ends without a row"),
            ("t_s,rtt_ms\n0,1\n\n7", "line 4: \"7\" must be two columns, t_s,rtt_ms"),
            ("t_s,rtt_ms\n0,1,2", "line 2: \"0,1,2\" must be two columns, t_s,rtt_ms"),
            ("t_s,rtt_ms\n0,x", "line 2: rtt_ms is \"x\", it must be a number"),
            ("t_s,rtt_ms\n,1", "line 2: t_s is \"\", it must be a number"),
            ("t_s,rtt_ms\n0,inf", "line 2: rtt_ms is inf, it must be finite"),
            ("t_s,rtt_ms\nNaN,1", "line 2: t_s is NaN, it must be finite"),
            ("t_s,rtt_ms\n0,-5", "line 2: rtt_ms is -5, it must not be negative"),
            ("t_s,rtt_ms\n-1,5", "line 2: t_s is -1, it must not be negative"),
            ("t_s,rtt_ms\n0,61000", "line 2: an RTT of 61 s is longer than 60 s"),
            ("t_s,rtt_ms\n3,1\n3,1", "line 3: t_s is 3, it must be greater than the 3 before it"),
        ];
        for (text, message) in cases {
            assert_eq!(parse_trace(text).expect_err(text).to_string(), message);
        }
        let rows = (0..=MAX_TRACE_ROWS).map(|i| (i as f64, 0.1)).collect();
        let line = MAX_TRACE_ROWS + 2;
        assert_eq!(RttTrace::new(rows), Err(TraceError::TooManyRows { line }));
        assert_eq!(RttTrace::new(vec![]), Err(TraceError::Empty { line: 1 }));
    }

    #[test]
    fn line_ends_blank_lines_and_byte_order_marks_do_not_matter() {
        let trace = parse_trace("\u{feff}t_s,rtt_ms\r\n0, 40\r\n\r\n 2,80\r\n").unwrap();
        assert_eq!(trace.rows(), [(0.0, 0.04), (2.0, 0.08)]);
        assert_eq!(trace.period(), 4.0);
        assert_eq!(RttTrace::new(vec![(3.0, 0.2)]).unwrap().at(-7.0), 0.2);
    }

    proptest! {
        #[test]
        fn the_row_in_force_is_the_last_at_or_before_and_repeats(
            steps in proptest::collection::vec(1u32..50, 2..20), cycles in -3..4i32, tick in 0u32..2000,
        ) {
            let mut time = 5.0;
            let rows: Vec<_> = steps.iter().enumerate().map(|(i, &step)| {
                time += f64::from(step) / 8.0;
                (time, i as f64 / 100.0)
            }).collect();
            let trace = RttTrace::new(rows.clone()).unwrap();
            let within = f64::from(tick) / 8.0 % trace.period();
            let naive = rows.iter().rfind(|row| row.0 <= rows[0].0 + within).unwrap().1;
            // eighths of seconds are exact in binary, so equality is
            prop_assert_eq!(trace.at(rows[0].0 + within + f64::from(cycles) * trace.period()), naive);
        }
    }
}
