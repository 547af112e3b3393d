//! Which link models mean something.

use super::limits::{LONGEST_DELAY, MAX_LATE_CORRELATION, MAX_OUTAGES, MAX_SILENCE_LOAD};
use super::{LatePackets, LinkModel, Outage, Rtt, SLOT, Silences};

/// Why a link model means nothing.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LinkError {
    /// A delay is not a number of seconds between 0 and [`LONGEST_DELAY`].
    #[error("{field} is {value}, it must be between 0 and {LONGEST_DELAY} s")]
    Delay {
        /// The field.
        field: &'static str,
        /// Its value in s.
        value: f64,
    },
    /// The quantiles of a lognormal RTT are not positive and increasing.
    #[error("an RTT of median {median} s and 99 % {p99} s must have 0 < median < 99 %")]
    Quantiles {
        /// Median in s.
        median: f64,
        /// 99 % quantile in s.
        p99: f64,
    },
    /// A probability is not in [0, 1].
    #[error("{field} is {value}, it must be between 0 and 1")]
    Probability {
        /// The field.
        field: &'static str,
        /// Its value.
        value: f64,
    },
    /// No chain of slots has these two probabilities, or its bursts never end.
    #[error(
        "no bursts of late slots have probability {probability} and probability {after_late} after a late one"
    )]
    Burst {
        /// Probability of a late slot.
        probability: f64,
        /// Probability of a late slot after a late one.
        after_late: f64,
    },
    /// An outage is not finite or has a negative duration.
    #[error("outage {index} from {start} s for {duration} s must be finite and not negative")]
    Outage {
        /// Index in the list.
        index: usize,
        /// Begin in s.
        start: f64,
        /// Length in s.
        duration: f64,
    },
    /// An outage begins before the one before it ended.
    #[error("outage {index} from {start} s begins before {end} s, the end of the one before it")]
    OutageOrder {
        /// Index in the list.
        index: usize,
        /// Begin in s.
        start: f64,
        /// End of the one before in s.
        end: f64,
    },
    /// There are more outages than the limit.
    #[error("{count} outages are more than {MAX_OUTAGES}")]
    TooManyOutages {
        /// How many there are.
        count: usize,
    },
    /// Silences are not some number per second with 0 < shortest <= longest.
    #[error(
        "{rate} silences per s of {shortest} to {longest} s must have 0 <= rate, 0 < shortest <= longest <= {LONGEST_DELAY}"
    )]
    Silences {
        /// Silences per s.
        rate: f64,
        /// Shortest in s.
        shortest: f64,
        /// Longest in s.
        longest: f64,
    },
    /// Silences join to one that does not end.
    #[error(
        "{rate} silences per s of {mean} s in the mean leave no link: at most one per two slots, at most {MAX_SILENCE_LOAD} at once"
    )]
    SilenceLoad {
        /// Silences per s.
        rate: f64,
        /// Mean duration in s.
        mean: f64,
    },
}

impl LinkModel {
    /// Checks every field; the first that means nothing is the error.
    pub fn validate(&self) -> Result<(), LinkError> {
        delay("sensor_delay", self.sensor_delay)?;
        match self.rtt {
            Rtt::Constant(rtt) => delay("rtt", rtt)?,
            Rtt::Lognormal { median, p99 } => {
                delay("p99", p99)?;
                if !(median > 0.0 && median < p99) {
                    return Err(LinkError::Quantiles { median, p99 });
                }
            }
            Rtt::Trace(_) => {}
        }
        self.late.validate()?;
        self.validate_outages()?;
        self.silences.validate()
    }

    fn validate_outages(&self) -> Result<(), LinkError> {
        if self.outages.len() > MAX_OUTAGES {
            return Err(LinkError::TooManyOutages { count: self.outages.len() });
        }
        let mut end = f64::NEG_INFINITY;
        for (index, &Outage { start, duration }) in self.outages.iter().enumerate() {
            if !(start.is_finite() && duration.is_finite() && duration >= 0.0) {
                return Err(LinkError::Outage { index, start, duration });
            }
            if start < end {
                return Err(LinkError::OutageOrder { index, start, end });
            }
            end = start + duration;
        }
        Ok(())
    }
}

impl LatePackets {
    fn validate(&self) -> Result<(), LinkError> {
        let Self { probability, after_late, extra } = *self;
        for (field, value) in [("probability", probability), ("after_late", after_late)] {
            if !(0.0..=1.0).contains(&value) {
                return Err(LinkError::Probability { field, value });
            }
        }
        let after_on_time = self.after_on_time();
        let correlation = after_late - after_on_time;
        if after_on_time > 1.0 || correlation.abs() > MAX_LATE_CORRELATION {
            return Err(LinkError::Burst { probability, after_late });
        }
        delay("extra", extra)
    }
}

impl Silences {
    fn validate(&self) -> Result<(), LinkError> {
        let Self { rate, shortest, longest } = *self;
        if !(rate >= 0.0 && shortest > 0.0 && shortest <= longest && longest <= LONGEST_DELAY) {
            return Err(LinkError::Silences { rate, shortest, longest });
        }
        let mean = self.mean_duration();
        if rate * SLOT > 0.5 || rate * mean > MAX_SILENCE_LOAD {
            return Err(LinkError::SilenceLoad { rate, mean });
        }
        Ok(())
    }
}

fn delay(field: &'static str, value: f64) -> Result<(), LinkError> {
    if (0.0..=LONGEST_DELAY).contains(&value) {
        Ok(())
    } else {
        Err(LinkError::Delay { field, value })
    }
}
