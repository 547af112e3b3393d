//! Measures the two fixed error models of the thesis and prints them as the constants of
//! `umwelt_core::identification::fixed`.
//!
//! `cargo run --release -p umwelt-core --example measure_fixed_models -- [SEED]` (default 1).

#![allow(clippy::print_stdout, reason = "an example prints")]

use umwelt_core::fixed_models::{ROUND_TRIPS, measure};
use umwelt_core::identification::estimate::Channel;
use umwelt_core::link::LinkModel;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let seed = std::env::args().nth(1).map_or(Ok(1), |seed| seed.parse())?;
    println!("{ROUND_TRIPS} round trips per link, seed {seed}");
    for name in ["normal", "bad"] {
        let link = LinkModel::preset(name).ok_or("no such preset")?;
        let model = measure(link, ROUND_TRIPS, seed)?;
        println!("{name}:");
        for (channel, (mean, variance)) in Channel::ALL.iter().zip(model) {
            let (name, sd) = (channel.name(), variance.sqrt());
            println!("  {name:8} mean {mean:8.4}  variance {variance:9.6}  (sd {sd:.3})");
        }
    }
    Ok(())
}
