//! Robots with one fault each, and robots with none.

mod healthy;
mod many;
mod robot;
mod tracker;
mod wheels;
