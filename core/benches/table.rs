//! Writes `BENCHMARKS.md` from what the other benches measured: `cargo bench -p umwelt-core` runs them first.
#![allow(
    clippy::disallowed_methods,
    clippy::print_stdout,
    reason = "a bench reads what criterion measured and writes a table"
)]

use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

/// A row: what it is, criterion's group and name, its limit in ns.
type Row = (&'static str, &'static str, &'static str, Option<f64>);

const CYCLES: [Row; 4] = [
    ("one slot, normal link", "cycle", "1-normal", Some(1000.0)),
    ("one slot, bad link", "cycle", "1-bad", Some(1000.0)),
    ("twenty slots, normal link", "cycle", "20-normal", Some(4000.0)),
    ("twenty slots, bad link", "cycle", "20-bad", Some(4000.0)),
];

const MONTE_CARLO_CYCLES: [Row; 5] = [
    ("one slot, 100 agents", "monte-carlo-cycle", "1-100", None),
    ("one slot, 1000 agents", "monte-carlo-cycle", "1-1000", None),
    ("one slot, 10 000 agents", "monte-carlo-cycle", "1-10000", None),
    ("twenty slots, 100 agents", "monte-carlo-cycle", "20-100", None),
    ("twenty slots, 1000 agents", "monte-carlo-cycle", "20-1000", None),
];

const PREDICTIONS: [Row; 4] = [
    ("moments", "prediction", "moments", None),
    ("Monte Carlo, 100 agents", "prediction", "monte-carlo-100", None),
    ("Monte Carlo, 1000 agents", "prediction", "monte-carlo-1000", None),
    ("Monte Carlo, 10 000 agents", "prediction", "monte-carlo-10000", None),
];

fn main() -> Result<(), Box<dyn Error>> {
    // target/release/deps/table-...
    let target =
        std::env::current_exe()?.ancestors().nth(3).ok_or("no target directory")?.to_owned();
    let mut text = format!(
        "# Benchmarks\n\n\
        Written by `cargo bench -p umwelt-core`. One thread on {}.\n\
        Times are criterion's medians with their 95 % confidence intervals.\n\n",
        machine()
    );
    text += "## A control cycle, moments predictor\n\n\
        30 ms of the thesis's episode (calibration and round trip, hard floor, camera noise): controller, link and plant, \
        all of the episode shared out over its cycles. Four seeds per sample.\n\n";
    table(&mut text, &target, &CYCLES)?;
    text += "\n## A control cycle, Monte-Carlo predictor\n\nThe first 3 s of the same episode, normal link.\n\n";
    table(&mut text, &target, &MONTE_CARLO_CYCLES)?;
    text += "\n## A prediction over eight slots\n\n";
    table(&mut text, &target, &PREDICTIONS)?;
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../BENCHMARKS.md");
    fs::write(&path, &text)?;
    println!("{text}");
    Ok(())
}

fn table(text: &mut String, target: &Path, rows: &[Row]) -> Result<(), Box<dyn Error>> {
    text.push_str("| what | median | 95 % interval | samples | limit | part of limit |\n");
    text.push_str("|---|--:|--:|--:|--:|--:|\n");
    for (what, group, name, limit) in rows {
        let of: PathBuf = target.join("criterion").join(group).join(name).join("new");
        let read = |file: &str| -> Result<serde_json::Value, Box<dyn Error>> {
            let path = of.join(file);
            let text = fs::read_to_string(&path).map_err(|error| format!("{path:?}: {error}"))?;
            Ok(serde_json::from_str(&text)?)
        };
        let (estimates, sample) = (read("estimates.json")?, read("sample.json")?);
        let samples = sample["times"].as_array().ok_or("no samples")?.len();
        // Throughput is stored with the benchmark: elements are cycles.
        let cycles = read("benchmark.json")?["throughput"]["Elements"].as_f64().unwrap_or(1.0);
        let number =
            |value: &serde_json::Value| value.as_f64().ok_or("no median").map(|x| x / cycles);
        let median = &estimates["median"];
        let interval = &median["confidence_interval"];
        let (half, low, high) = (
            number(&median["point_estimate"])?,
            number(&interval["lower_bound"])?,
            number(&interval["upper_bound"])?,
        );
        let (limit, part) = limit.map_or((String::new(), String::new()), |limit| {
            (time(limit), format!("{:.2}", half / limit))
        });
        writeln!(
            text,
            "| {what} | {} | {}..{} | {samples} | {limit} | {part} |",
            time(half),
            time(low),
            time(high)
        )?;
    }
    Ok(())
}

/// A time in ns with its unit.
fn time(ns: f64) -> String {
    match ns {
        ..1e3 => format!("{ns:.0} ns"),
        1e3..1e6 => format!("{:.2} µs", ns / 1e3),
        _ => format!("{:.2} ms", ns / 1e6),
    }
}

/// The processor's name, where the system tells it.
fn machine() -> String {
    let text = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text.lines().find(|line| line.starts_with("model name"));
    let name = name.and_then(|line| line.split_once(": ")).map_or("unknown", |(_, name)| name);
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    format!("{name}, {cores} logical processors, other work running beside it or not")
}
