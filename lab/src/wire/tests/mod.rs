//! Laws: lab -> wire -> JSON -> wire -> lab loses nothing, and nothing wrong gets through.

mod comparison;
mod evolution;
mod training;

use proptest::prelude::*;
use umwelt_api::{Problems, Range, robot};

/// The largest whole number that JSON holds exactly everywhere.
const MAX: u64 = robot::MAX_INTEGER;

fn within(range: Range) -> impl Strategy<Value = f64> {
    // Both ends are allowed values, and the likeliest to be lost.
    prop_oneof![8 => range.min..=range.max, 1 => Just(range.min), 1 => Just(range.max)]
}

/// `(reason, field)` of each problem.
fn problems<T: std::fmt::Debug>(read: Result<T, Problems>) -> Vec<(String, String)> {
    let problems = read.expect_err("it is wrong");
    problems.details().iter().map(|detail| (detail.reason.clone(), detail.field.clone())).collect()
}

fn pairs(expected: &[(&str, &str)]) -> Vec<(String, String)> {
    expected.iter().map(|(reason, field)| ((*reason).to_owned(), (*field).to_owned())).collect()
}
