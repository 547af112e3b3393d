//! Stops and resumes: the last to arrive holds, and what is acknowledged outlives the process.

use crate::api::{Api, config, step};
use crate::process::{end, program, start};
use crate::sockets::request;
use crate::stores::Gate;
use futures_util::future::join_all;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde_json::{Value, json};
use std::net::SocketAddr;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tempfile::tempdir;
use umwelt_server::store::DATA_FILE;
use umwelt_server::{Config, Server};

/// What a stop may take here, where the issue allows 0.3 s: the machine has other things to do.
const GENEROUS: Duration = Duration::from_secs(5);

/// Guards against: a resume that still waits for the disk undoes a stop that was acknowledged in the meantime.
#[tokio::test]
async fn a_resume_that_a_stop_has_overtaken_has_no_effect_and_says_so() {
    let gate = Arc::new(Gate::default());
    let api = Api::with(config(), gate.clone()).await;
    api.add("r").await;
    assert_eq!(api.post("/v1/robots/r/stop").await.code, 200);
    for all in [false, true] {
        let (resume, stop) = if all {
            ("/v1/resume", "/v1/stop")
        } else {
            ("/v1/robots/r/resume", "/v1/robots/r/stop")
        };
        let shut = gate.shut();
        let resuming = tokio::spawn({
            let api = api.clone();
            async move { api.post(resume).await }
        });
        gate.reached(if all { 2 } else { 1 }).await;
        let stopped = api.post(stop).await;
        assert_eq!((stopped.code, &stopped.json()["stopped"]), (200, &json!(true)));
        assert_eq!(stopped.json()["kept"], false, "the store is held and there is no journal");
        drop(shut);
        let resumed = resuming.await.unwrap();
        assert_eq!(resumed.code, 409, "{resumed:?}");
        assert_eq!(resumed.problem(), ("ABORTED".into(), "OVERTAKEN".into()));
        assert_eq!(api.get("/v1/robots/r").await.json()["stopped"], true);
        let again = Api::with(config(), gate.clone()).await;
        assert_eq!(again.get("/v1/robots/r").await.json()["stopped"], true, "nor in the store");
        assert_eq!(api.step(step(7, 1 + u64::from(all), 10.0, 0.0)).await.json()["stopped"], true);
    }
    assert_eq!(api.post("/v1/robots/r/resume").await.code, 200);
    assert_eq!(api.get("/v1/robots/r").await.json()["stopped"], false);
}

fn serve(directory: &Path) -> (std::process::Child, SocketAddr) {
    let data = directory.to_str().unwrap();
    start(program(&["serve", "--listen", "127.0.0.1:0", "--data", data]))
}

fn body(answer: &str) -> Value {
    serde_json::from_str(answer.split_once("\r\n\r\n").unwrap().1).unwrap()
}

/// Guards against: a stop is acknowledged while another program holds the store, the server dies, and the robot
/// drives on. And its way back: a resume acknowledged then.
#[tokio::test]
async fn words_outlive_the_process_although_the_store_is_held() {
    let directory = tempdir().unwrap();
    let (child, address) = serve(directory.path());
    for robot in ["r", "s", "t"] {
        let put = request(address, "PUT", &format!("/v1/robots/{robot}"), "{}").await;
        assert!(put.starts_with("HTTP/1.1 201"), "{put}");
    }
    request(address, "POST", "/v1/robots/s/stop", "").await;
    let store = rusqlite::Connection::open(directory.path().join(DATA_FILE)).unwrap();
    store.execute_batch("BEGIN IMMEDIATE").unwrap();
    let asked = Instant::now();
    for (path, stopped) in
        [("/v1/robots/r/stop", true), ("/v1/stop", true), ("/v1/robots/s/resume", false)]
    {
        let answer = request(address, "POST", path, "").await;
        assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
        assert_eq!(body(&answer)["stopped"], stopped);
        assert_eq!(body(&answer)["kept"], true, "{answer}");
    }
    assert!(asked.elapsed() < GENEROUS, "{:?}", asked.elapsed());
    end(child, "-KILL");
    drop(store);
    // The second time what the first one has brought into the store.
    for _ in 0..2 {
        let (child, address) = serve(directory.path());
        for (robot, stopped) in [("r", true), ("s", false), ("t", true)] {
            let answer = request(address, "GET", &format!("/v1/robots/{robot}"), "").await;
            assert_eq!(body(&answer)["stopped"], stopped, "{robot}");
        }
        assert_eq!(end(child, "-TERM").status.code(), Some(0));
    }
}

/// Guards against: a signal that does not end the process, whatever its disk does.
#[tokio::test]
async fn a_signal_ends_the_process_although_the_store_is_held() {
    let directory = tempdir().unwrap();
    let (child, address) = serve(directory.path());
    request(address, "PUT", "/v1/robots/r", "{}").await;
    let store = rusqlite::Connection::open(directory.path().join(DATA_FILE)).unwrap();
    store.execute_batch("BEGIN IMMEDIATE").unwrap();
    let body = step(7, 1, 10.0, 0.0).to_string();
    assert!(request(address, "POST", "/v1/robots/r/step", &body).await.starts_with("HTTP/1.1 200"));
    let asked = Instant::now();
    end(child, "-TERM");
    let Config { drain, close, .. } = Config::default();
    assert!(asked.elapsed() < drain + close + GENEROUS, "{:?}", asked.elapsed());
}

/// Guards against: a clock that has counted for long makes a step compute for ever.
#[tokio::test(start_paused = true)]
async fn steps_are_answered_whatever_the_clock_reads_and_however_long_it_paused() {
    let api = Api::with_robot().await;
    let mut epoch = 0;
    for clock in [8.49e8, 5.37e8, -8.49e8, 9.99e8, -1e9, 0.0] {
        for (pause, age) in [(5.0, 1.0), (1.2, 0.02), (2.0, 0.02), (0.5, 0.3), (86_400.0, 0.1)] {
            epoch += 1;
            for (sequence, sent) in [(1, clock), (2, clock + 0.03), (3, clock + 0.06 + pause)] {
                let pose =
                    json!({"x_m": 0.0, "y_m": 0.0, "heading_rad": 0.0, "taken_s": sent - age});
                let pose = if sent - age < -1e9 { json!([]) } else { json!([pose]) };
                let body = json!({"epoch": epoch, "sequence": sequence, "sent_s": sent, "observations": pose});
                let answer = api.step(body).await;
                assert_eq!(answer.code, 200, "{clock} {pause} {answer:?}");
                let start = answer.json()["horizon"]["start_s"].as_f64().unwrap();
                assert!((start - sent).abs() < 1.0, "{start} for {sent}");
            }
        }
    }
}

/// All robots go on and are stopped at some moment on the way: none goes on, now or after a restart.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn of_a_thousand_robots_none_goes_on_after_the_stop_of_all() {
    const ROBOTS: usize = 1000;
    let directory = tempdir().unwrap();
    let config = Config { data: Some(directory.path().to_path_buf()), ..config() };
    let server = Server::bind(config.clone()).await.unwrap();
    let api = Api(server.router());
    let put = |number: usize| {
        let api = api.clone();
        async move {
            assert_eq!(api.put(&format!("/v1/robots/m{number}"), json!({})).await.code, 201);
        }
    };
    for numbers in (0..ROBOTS).collect::<Vec<_>>().chunks(100) {
        join_all(numbers.iter().map(|number| put(*number))).await;
    }
    assert_eq!(api.post("/v1/stop").await.json()["robots"], ROBOTS);
    let mut random = Pcg64Mcg::seed_from_u64(10);
    for attempt in 0..12 {
        let resuming = tokio::spawn({
            let api = api.clone();
            async move { api.post("/v1/resume").await }
        });
        tokio::time::sleep(Duration::from_micros(random.random_range(0..20_000))).await;
        let asked = Instant::now();
        let stopped = api.post("/v1/stop").await;
        assert_eq!((stopped.code, &stopped.json()["kept"]), (200, &json!(true)), "{stopped:?}");
        assert!(asked.elapsed() < GENEROUS, "{:?}", asked.elapsed());
        let resumed = resuming.await.unwrap();
        assert!([200, 409].contains(&resumed.code), "{resumed:?}");
        assert_eq!(going(&api).await, 0, "attempt {attempt}");
    }
    // The next server reads what this one has written down so far, be it in the store or beside it.
    drop((api, server));
    let again = loop {
        match Server::bind(config.clone()).await {
            Ok(server) => break Api(server.router()),
            Err(error) => assert!(error.to_string().contains("in use"), "{error}"),
        }
        tokio::time::sleep(Duration::from_millis(10)).await;
    };
    assert_eq!(going(&again).await, 0);
}

/// How many robots are not stopped.
async fn going(api: &Api) -> usize {
    let mut going = 0;
    let mut path = "/v1/robots?page_size=500".to_owned();
    loop {
        let page = api.get(&path).await.json();
        let robots = page["robots"].as_array().unwrap();
        going += robots.iter().filter(|robot| robot["stopped"] == false).count();
        match page["next_page_token"].as_str() {
            Some(token) => path = format!("/v1/robots?page_size=500&page_token={token}"),
            None => return going,
        }
    }
}
