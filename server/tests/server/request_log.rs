//! Recorded requests of three robots, and what they are answered: not a digit of a horizon changes unnoticed.
//!
//! The files were recorded from simulated robots; `UPDATE_GOLDEN=1 cargo test -p umwelt-server --test server request_log`
//! writes the answers anew, which belongs to a change of results that CHANGELOG names.

use crate::api::Api;
use crc::{CRC_64_XZ, Crc};
use serde_json::Value;
use std::fmt::Write;
use std::{env, fs};

/// One line per answer: checksum of its bytes, then what a reader looks for first.
async fn answers(log: &str) -> String {
    let api = Api::new().await;
    let mut lines = log.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    let told = lines.next().unwrap();
    assert_eq!(api.put("/v1/robots/r", told["robot"].clone()).await.code, 201);
    assert_eq!(api.put("/v1/robots/r/task", told["task"].clone()).await.code, 201);
    let mut answers = String::new();
    for step in lines {
        let answer = api.step(step).await;
        assert_eq!(answer.code, 200, "{answer:?}");
        let checksum = Crc::<u64>::new(&CRC_64_XZ).checksum(&answer.bytes);
        let answer = answer.json();
        let [first, .., last] = &answer["horizon"]["wheel_speeds"].as_array().unwrap()[..] else {
            let only = &answer["horizon"]["wheel_speeds"][0];
            writeln!(answers, "{checksum:016x} {} {only}", answer["stage"]).unwrap();
            continue;
        };
        writeln!(answers, "{checksum:016x} {} {first} .. {last}", answer["stage"]).unwrap();
    }
    let environment = api.get("/v1/robots/r/environment").await.json();
    writeln!(answers, "{environment}").unwrap();
    answers
}

#[tokio::test(start_paused = true)]
async fn recorded_requests_are_answered_as_they_were() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/server/request-log");
    for name in ["bayesian-20-bad-link", "statistic-1-played", "monte-carlo-drift"] {
        let log = fs::read_to_string(format!("{folder}/{name}.jsonl")).unwrap();
        let (answers, golden) = (answers(&log).await, format!("{folder}/{name}.answers"));
        if env::var_os("UPDATE_GOLDEN").is_some() {
            fs::write(&golden, &answers).unwrap();
        }
        let golden = fs::read_to_string(golden).unwrap();
        for (index, (answer, golden)) in answers.lines().zip(golden.lines()).enumerate() {
            assert_eq!(answer, golden, "{name}, answer {}", index + 1);
        }
        assert_eq!(answers.lines().count(), golden.lines().count(), "{name}");
    }
}
