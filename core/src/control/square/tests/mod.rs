//! Squares driven by simulated robots, whose wheels and track are not as described.

mod figures;
mod robot;
mod unruly;
