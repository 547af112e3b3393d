//! The table of docs/results.md: links x horizons, five seeds of a fleet each.

use crate::{Options, run, show};
use std::error::Error;
use std::io::{Write as _, stdout};

/// Seeds per line of the table.
const SEEDS: u64 = 5;

/// Drives every combination and prints the table; whether everybody arrived everywhere.
pub async fn run(options: &Options) -> Result<bool, Box<dyn Error>> {
    let seeds: Vec<u64> = (options.seed..options.seed + SEEDS).collect();
    let mut out = stdout();
    let mut all_arrived = true;
    if !options.json {
        writeln!(
            out,
            "| slots | link | robots | arrived | median time s | median deviation mm | p90 deviation mm |"
        )?;
        writeln!(out, "|--:|---|--:|--:|--:|--:|--:|")?;
    }
    for slots in [1, 20] {
        for link in ["clean", "normal", "bad"] {
            eprintln!("{slots} slots, {link} link, seeds {seeds:?}");
            let summary = run::fleet(options, &seeds, slots, link).await?;
            all_arrived &= summary.all_arrived();
            if options.json {
                show::summary(&summary, true)?;
                continue;
            }
            writeln!(
                out,
                "| {slots} | {link} | {} | {} | {:.2} | {:.1} | {:.1} |",
                summary.robots.len(),
                summary.robots.iter().filter(|finish| finish.arrived).count(),
                summary.median_time_s,
                summary.median_deviation_m * 1e3,
                summary.p90_deviation_m * 1e3
            )?;
        }
    }
    Ok(all_arrived)
}
