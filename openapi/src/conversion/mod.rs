//! Wire types to core's types and back: the only files of this crate that name `umwelt_core`.
//!
//! What a [`Checked`](crate::Checked) body means is `to_core`; `convert` is the same for what a program keeps, which was
//! checked when it came, without the ranges of the day.

mod drive;
mod environment;
mod noise;
#[cfg(test)]
mod numbers;
mod prior;
mod robot;
mod robot_check;
mod square;
mod step;
mod task;
mod training;
mod watch;

/// The number where it is finite; `null` on the wire otherwise.
fn known(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}
