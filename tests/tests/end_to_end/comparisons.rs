//! Comparisons of methods, as people ask for them.

use super::evolutions::{EVOLUTION as COMPARISON, get, has_succeeded, post, until};
use serde_json::{Value, json};
use std::fs;
use umwelt_tests::data::Data;
use umwelt_tests::said::{call_within, compare, umwelt};
use umwelt_tests::server::Server;

/// A small comparison by flags: a second of one core.
const FLAGS: &str = "--scenario thesis --methods statistic,bayesian,oracle/1 --trials 3 --seed 5";

/// The same in JSON.
fn small() -> String {
    json!({
        "scenario": "thesis", "methods": ["statistic", "bayesian", "oracle/1"], "trials": 3, "seed": 5,
    })
    .to_string()
}

/// One that goes on until it is stopped.
fn endless() -> String {
    json!({"scenario": "bursty", "methods": ["statistic", "bayesian"], "trials": 10_000})
        .to_string()
}

async fn submit(server: &Server, body: &str) -> String {
    let answer = post(server, "/v1/comparisons", "", body).await;
    assert_eq!(answer.code, 201, "{answer:?}");
    answer.header("location").unwrap().to_owned()
}

/// Guards against numbers that depend on where they were asked for, or a claim that reads well whatever they are.
#[tokio::test]
async fn a_comparison_says_the_same_on_the_command_line_over_http_and_offline() {
    let server = Server::start();
    let url = server.url();
    let arguments: Vec<&str> =
        ["--server", &url, "compare", "--watch"].into_iter().chain(FLAGS.split(' ')).collect();
    let said = call_within("umwelt", &arguments, COMPARISON).await;
    assert_eq!(said.code, Some(0), "{}", said.log);
    let text = said.output.join("\n");
    for words in ["bad-link", "bayesian/20", "oracle/1", "of the thesis's 75 %", "35 %"] {
        assert!(text.contains(words), "no {words} in {text}");
    }
    let shown = umwelt(&server, "comparison show comparison-1").await;
    assert_eq!((&shown["state"], &shown["spec"]["trials"]), (&json!("succeeded"), &json!(3)));
    let report = &shown["report"];
    assert_eq!(report["environments"].as_array().map(Vec::len), Some(2));
    assert_eq!(report["claims"].as_array().map(Vec::len), Some(4), "two links, two horizons");
    for claim in report["claims"].as_array().unwrap() {
        let findings = claim["findings"].as_array().unwrap();
        let words: Vec<_> = findings.iter().map(|it| it["words"].as_str().unwrap()).collect();
        assert_eq!(claim["verdict"], words.join("; "));
        assert!(words.iter().all(|words| text.contains(words)), "{claim}");
    }
    let listed = umwelt(&server, "comparison list").await;
    assert_eq!(listed["comparisons"].as_array().map(Vec::len), Some(1));

    let folder = Data::new();
    let flags = format!("{FLAGS} --threads 1 --out {}", folder.text());
    let offline = compare(&flags, COMPARISON).await;
    assert_eq!(&offline["report"], report, "offline, on one thread");
    let again: Value =
        serde_json::from_str(&fs::read_to_string(folder.file("report.json")).unwrap()).unwrap();
    assert_eq!(&again["report"], report);
    for (what, file) in [("trials", "trials.csv"), ("report", "compare.md")] {
        let arguments = ["--server", &url, "comparison", what, "comparison-1"];
        let said = call_within("umwelt", &arguments, COMPARISON).await;
        assert_eq!(said.code, Some(0), "{}", said.log);
        let written = fs::read_to_string(folder.file(file)).unwrap();
        assert_eq!(said.output, written.lines().collect::<Vec<_>>(), "{file}");
        // Five contenders in two environments, three trials each, and the names of the columns.
        assert!(what != "trials" || said.output.len() == 31, "{written}");
        assert!(what != "report" || written.contains("## What the thesis claims"), "{written}");
    }
    for name in ["deviation.svg", "time.svg", "pareto.svg"] {
        let drawn = fs::read_to_string(folder.file(name)).unwrap();
        roxmltree::Document::parse(&drawn).unwrap_or_else(|error| panic!("{name}: {error}"));
    }
}

/// Guards against a killed server that begins anew, or comes to other numbers than one that lived.
#[tokio::test]
async fn a_killed_server_goes_on_and_comes_to_the_same() {
    let data = Data::new();
    let mut server = Server::start_with(&["--data", data.text()]);
    let path = submit(&server, &endless()).await;
    let next = submit(&server, &small()).await;
    let goes_on = |it: &Value| it["progress"]["trials_done"].as_u64() > Some(0);
    until(&server, &path, "a batch", goes_on).await;
    server.process.kill();

    let server = Server::start_with(&["--data", data.text()]);
    let found = get(&server, &path).await;
    assert!(goes_on(&found), "it begins anew: {found}");
    let again = until(&server, &path, "it goes on", |it| it["state"] == "running").await;
    assert_eq!(again["interrupted"], 1);
    let cancelled = post(&server, &format!("{path}/cancel"), "", "").await;
    assert_eq!(cancelled.code, 200, "{cancelled:?}");
    let done = until(&server, &next, "the next succeeds", has_succeeded).await;
    assert_eq!(done["report"], compare(FLAGS, COMPARISON).await["report"]);
}
