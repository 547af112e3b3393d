//! `umwelt-server evolve` and `compare`: what it writes, and how it ends.

use crate::api::Api;
use crate::process::program;
use serde_json::Value;
use std::path::Path;
use tempfile::tempdir;
use umwelt_api::evolution::{Preset, Request};
use umwelt_server::offline::Order;

const SMALL: [&str; 13] = [
    "evolve",
    "--preset",
    "quick",
    "--environments",
    "normal",
    "--population",
    "4",
    "--generations",
    "3",
    "--trials",
    "1",
    "--selection-trials=1",
    "--report-trials=2",
];

fn evolve(more: &[&str]) -> (Option<i32>, String, String) {
    let output = program(&[&SMALL[..], more].concat()).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

fn read(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).unwrap()
}

/// Guards against: a prior that was drawn at random, in a folder as if it had been found.
#[test]
fn an_evolution_without_fitness_fails_with_the_reason() {
    let directory = tempdir().unwrap();
    // No one is there so soon.
    let request = Request {
        preset: Some(Preset::Quick),
        environments: Some(vec!["bad-link".to_owned()]),
        population: Some(4),
        generations: Some(2),
        trials: Some(1),
        max_time_s: Some(1.0),
        ..Request::default()
    };
    let folder = Some(directory.path().to_owned());
    let mut output = Vec::new();
    let order = Order { request, folder, json: true, threads: Some(2) };
    let error = umwelt_server::offline::evolve(&order, &mut output).unwrap_err().to_string();
    assert!(error.starts_with("it has failed: the champion is of no use in bad-link: "), "{error}");
    assert_eq!(output, b"");
    assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 0, "nothing is written");
}

/// Guards against: a folder that lacks what the report speaks of, a prior that no server takes.
#[tokio::test]
async fn the_folder_holds_what_was_found_and_a_server_takes_the_prior() {
    let directory = tempdir().unwrap();
    let folder = directory.path().join("new/one");
    let (code, output, _) = evolve(&["--json", "--out", folder.to_str().unwrap()]);
    assert_eq!((code, &output), (Some(0), &read(&folder, "report.json")));
    let report: Value = serde_json::from_str(&output).unwrap();
    assert_eq!(report["fitness"], report["champion"]["entries"][0]["fitness"]);
    assert!(report["wall_time_s"].as_f64() > Some(0.0) && report["threads"].as_u64() > Some(0));
    for entry in report["champion"]["entries"].as_array().unwrap() {
        assert!(!entry["verdict"].as_str().unwrap().is_empty());
    }
    let csv = read(&folder, "generations.csv");
    let columns: Vec<_> = csv.lines().map(|line| line.split(',').count()).collect();
    assert_eq!(columns, [8; 4], "{csv}");
    for figure in ["deviation.svg", "time.svg"] {
        assert!(read(&folder, figure).starts_with("<svg"));
    }
    let api = Api::new().await;
    let prior: Value = serde_json::from_str(&read(&folder, "prior.json")).unwrap();
    assert_eq!(api.put("/v1/priors/mine", prior).await.code, 201);
    let kept = api.get("/v1/priors/mine").await.json();
    assert_eq!(kept["forward"], report["champion"]["prior"]["forward"]);
    assert!(kept["note"].as_str().unwrap().contains("seed 1"));
}

#[test]
fn the_report_is_the_same_on_any_number_of_threads_and_fit_to_be_read() {
    let champion = |threads: &str| -> Value {
        let (code, output, _) = evolve(&["--json", "--threads", threads]);
        assert_eq!(code, Some(0));
        serde_json::from_str::<Value>(&output).unwrap()["champion"].clone()
    };
    assert_eq!(champion("1"), champion("3"));
    let (code, text, _) = evolve(&[]);
    assert_eq!(code, Some(0));
    for said in ["champion", "first-generation", "default", "flat", "forward", "3 generations"] {
        assert!(text.contains(said), "{said} is not in\n{text}");
    }
}

#[test]
fn a_call_that_makes_no_sense_is_told_everything_at_once() {
    let wrong = ["--population=1", "--trials=0", "--environments=lava", "--elites=9"];
    let output = program(&[&["evolve"], &wrong[..]].concat()).output().unwrap();
    assert_eq!((output.status.code(), output.stdout), (Some(2), Vec::new()));
    let said = String::from_utf8(output.stderr).unwrap();
    for field in ["population", "trials", "environments[0]", "elites"] {
        assert!(said.contains(field), "{field} is not in\n{said}");
    }
    for wrong in [["--threads", "0"], ["--preset", "huge"], ["--optimizer", "luck"]] {
        assert_eq!(evolve(&wrong).0, Some(2), "{wrong:?}");
    }
    let (code, output, error) = evolve(&["--out", "/dev/null/x"]);
    assert_eq!((code, output.as_str()), (Some(1), ""), "{error}");
    assert!(error.contains("/dev/null/x"), "{error}");
}

fn compare(more: &[&str]) -> (Option<i32>, String, String) {
    let small = ["compare", "--methods", "statistic/1,bayesian/1", "--trials", "3"];
    let output = program(&[&small[..], more].concat()).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

#[test]
fn methods_are_compared_into_a_folder_whatever_the_number_of_threads() {
    let directory = tempdir().unwrap();
    let folder = directory.path().join("new/one");
    let out = folder.to_str().unwrap();
    let (code, output, error) = compare(&["--json", "--threads", "1", "--seed", "5", "--out", out]);
    assert_eq!((code, &output), (Some(0), &read(&folder, "report.json")), "{error}");
    let report: Value = serde_json::from_str(&output).unwrap();
    assert_eq!((&report["spec"]["seed"], &report["threads"]), (&5.into(), &1.into()));
    let rows: Vec<_> = read(&folder, "trials.csv").lines().map(str::to_owned).collect();
    assert_eq!(rows.len(), 1 + 2 * 2 * 3);
    assert!(read(&folder, "compare.md").starts_with("# "));
    for figure in ["deviation.svg", "time.svg", "pareto.svg"] {
        assert!(read(&folder, figure).starts_with("<svg"));
    }
    // The mean of the report is that of the rows.
    let of = |row: &&String| row.starts_with("bad-link,bayesian/1,");
    let times = rows.iter().filter(of).map(|row| row.split(',').nth(4).unwrap());
    let mean = times.map(|time| time.parse::<f64>().unwrap()).sum::<f64>() / 3.0;
    let entry = &report["report"]["environments"][1]["entries"][1];
    assert!((entry["time_s"]["mean"]["mean"].as_f64().unwrap() - mean).abs() < 1e-9, "{entry}");

    let (_, other, _) = compare(&["--json", "--threads", "3", "--seed", "5"]);
    let other: Value = serde_json::from_str(&other).unwrap();
    assert_eq!(other["report"], report["report"]);
    let (code, text, _) = compare(&[]);
    assert_eq!(code, Some(0));
    for said in ["scenario thesis, seed 1", "bad-link", "statistic/1", "what the thesis claims"] {
        assert!(text.contains(said), "{said} is not in\n{text}");
    }
}

#[test]
fn a_comparison_that_makes_no_sense_is_told_everything_at_once() {
    let wrong = ["compare", "--methods", "luck,bayesian/7", "--trials", "1", "--prior", "oasis"];
    let output = program(&wrong).output().unwrap();
    assert_eq!((output.status.code(), output.stdout), (Some(2), Vec::new()));
    let said = String::from_utf8(output.stderr).unwrap();
    for field in ["methods[0]", "methods[1]", "trials", "prior"] {
        assert!(said.contains(field), "{field} is not in\n{said}");
    }
    for wrong in [["--threads", "0"], ["--scenario", "moon"]] {
        assert_eq!(compare(&wrong).0, Some(2), "{wrong:?}");
    }
}
