//! What the values of flags may be.

use std::time::Duration;

/// From a millisecond to an hour.
pub(super) fn seconds(text: &str) -> Result<Duration, String> {
    match text.parse::<f64>() {
        Ok(seconds) if (1e-3..=3600.0).contains(&seconds) => Ok(Duration::from_secs_f64(seconds)),
        _ => Err("use a number of seconds from 0.001 to 3600".to_owned()),
    }
}

/// From a megabyte to a terabyte.
pub(super) fn megabytes(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(megabytes) if (1..=1 << 20).contains(&megabytes) => Ok(megabytes),
        _ => Err("use an integer from 1 to 1048576".to_owned()),
    }
}

/// Where nothing at all would be served with none.
pub(super) fn at_least_one(text: &str) -> Result<u32, String> {
    match text.parse() {
        Ok(number) if number >= 1 => Ok(number),
        _ => Err("use an integer from 1 to 4294967295".to_owned()),
    }
}

/// More threads than any machine has cores are a mistake.
pub(super) fn threads(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(threads) if (1..=1024).contains(&threads) => Ok(threads),
        _ => Err("use an integer from 1 to 1024".to_owned()),
    }
}
