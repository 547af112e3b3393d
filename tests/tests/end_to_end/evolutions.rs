//! Evolutions and the priors that come of them, as people ask for them.

use serde_json::{Value, json};
use std::fs;
use std::time::Duration;
use umwelt_tests::data::Data;
use umwelt_tests::http::{self, Answer};
use umwelt_tests::process::Signal;
use umwelt_tests::said::{Said, call, call_within, evolve, umwelt};
use umwelt_tests::server::Server;
use umwelt_tests::wait;

/// Time for a small evolution, which has low priority, beside all the other tests.
pub(super) const EVOLUTION: Duration = Duration::from_secs(120);

/// A small evolution in JSON and by flags: a second or two of one core. The contract's flags leave out the trials of
/// selection and report, so that they are here only.
pub(super) fn small(seed: u64) -> String {
    json!({
        "preset": "quick", "environments": ["normal"], "population": 6, "generations": 3, "trials": 1,
        "selection_trials": 2, "report_trials": 4, "seed": seed,
    })
    .to_string()
}

fn small_flags(seed: u64) -> String {
    format!(
        "--preset quick --environments normal --population 6 --generations 3 --trials 1 --selection-trials 2 \
         --report-trials 4 --seed {seed}"
    )
}

/// One that goes on until it is cancelled.
pub(super) fn endless() -> String {
    json!({"preset": "quick", "environments": ["normal"], "population": 6, "generations": 1000, "seed": 7})
        .to_string()
}

pub(super) async fn get(server: &Server, path: &str) -> Value {
    let answer = http::call(server.address, "GET", path, &[], b"").await;
    assert_eq!(answer.code, 200, "{path}: {answer:?}");
    answer.json()
}

pub(super) async fn post(server: &Server, path: &str, key: &str, body: &str) -> Answer {
    let headers: &[(&str, &str)] = if key.is_empty() { &[] } else { &[("Idempotency-Key", key)] };
    http::call(server.address, "POST", path, headers, body.as_bytes()).await
}

/// Submits an evolution; returns its path.
pub(super) async fn submit(server: &Server, body: &str) -> String {
    let answer = post(server, "/v1/evolutions", "", body).await;
    assert_eq!(answer.code, 201, "{answer:?}");
    answer.header("location").unwrap().to_owned()
}

/// Waits until an evolution shows that `holds`.
pub(super) async fn until(
    server: &Server,
    path: &str,
    what: &str,
    holds: impl Fn(&Value) -> bool,
) -> Value {
    wait::until(what, EVOLUTION, async || {
        let now = get(server, path).await;
        assert_ne!(now["state"], "failed", "{now}");
        holds(&now).then_some(now)
    })
    .await
}

pub(super) fn has_succeeded(evolution: &Value) -> bool {
    evolution["state"] == "succeeded"
}

/// Whether it goes on, and a generation has ended.
pub(super) fn goes_on(evolution: &Value) -> bool {
    evolution["state"] == "running" && evolution["progress"]["generation"].as_u64() > Some(0)
}

async fn umwelt_text(server: &Server, arguments: &str) -> Said {
    let url = server.url();
    let all: Vec<&str> = ["--server", &url].into_iter().chain(arguments.split(' ')).collect();
    call_within("umwelt", &all, EVOLUTION).await
}

/// Guards against: the watching ends before there is a report, or never, or a script cannot read it.
#[tokio::test]
async fn a_watched_evolution_ends_with_its_report_and_its_prior_can_be_used() {
    let server = Server::start();
    let flags = "evolve --preset quick --environments normal --population 6 --generations 3 --trials 1 --seed 4 \
                 --prior tried --watch";
    let said = umwelt_text(&server, flags).await;
    assert_eq!(said.code, Some(0), "{}", said.log);
    let text = said.output.join("\n");
    for word in ["evolution-1: succeeded", "champion", "first-generation", "default", "flat"] {
        assert!(text.contains(word), "no {word} in {text}");
    }
    assert!(text.contains("no difference") || text.contains(" .. "), "intervals: {text}");
    assert!(said.log.contains("evolution-1"), "progress: {}", said.log);

    let shown = umwelt(&server, "evolution show evolution-1").await;
    assert_eq!((&shown["state"], &shown["prior"]), (&json!("succeeded"), &json!("tried")));
    let listed = umwelt(&server, "evolution list").await;
    assert_eq!(listed["evolutions"].as_array().map(Vec::len), Some(1), "{listed}");
    let prior = umwelt(&server, "prior show tried").await;
    let source = json!("evolution-1");
    assert_eq!((&prior["source"]["evolution"], &prior["source"]["seed"]), (&source, &json!(4)));

    // A robot that names it uses it, and can say why.
    let robot = umwelt(&server, "robot add rover-7 --prior tried --method bayesian").await;
    assert_eq!(robot["spec"]["prior"], "tried");
    let environment = umwelt(&server, "environment show rover-7").await;
    assert_eq!(environment["prior"]["name"], "tried");
    let why = environment["prior"]["why"].as_str().unwrap();
    assert!(why.contains("tried") && why.contains("evolution-1 found"), "{why}");
    let mean = &environment["channels"]["forward"]["mean"];
    let mu = &shown["champion"]["prior"]["forward"]["mu"];
    assert_eq!(mean, mu, "without samples the belief is the prior's");
    let text = umwelt_text(&server, "environment show rover-7").await.output.join("\n");
    assert!(text.contains("tried") && text.contains("evolution-1"), "{text}");

    // As long as it does, the prior stays.
    let removed = umwelt_text(&server, "prior remove tried").await;
    assert_eq!(removed.code, Some(1), "{removed:?}");
    assert!(removed.log.contains("rover-7"), "{}", removed.log);
    umwelt(&server, "robot remove rover-7").await;
    umwelt(&server, "prior remove tried").await;
    assert_eq!(umwelt_text(&server, "prior show tried").await.code, Some(1));
}

/// Guards against: one polls an evolution that nothing can end, or a cancelled one goes on in the background.
#[tokio::test]
async fn an_evolution_is_submitted_polled_and_cancelled_and_the_next_has_its_turn() {
    let server = Server::start();
    let path = submit(&server, &endless()).await;
    assert_eq!(path, "/v1/evolutions/evolution-1");
    let second = submit(&server, &small(1)).await;
    until(&server, &path, "a generation", goes_on).await;
    assert_eq!(get(&server, &second).await["state"], "queued");
    let refused = http::call(server.address, "DELETE", &path, &[], b"").await;
    assert_eq!(
        (refused.code, &refused.json()["error"]["status"]),
        (409, &"FAILED_PRECONDITION".into())
    );
    let cancelled = post(&server, &format!("{path}/cancel"), "", "").await;
    assert_eq!(cancelled.code, 200, "{cancelled:?}");
    let ended = until(&server, &path, "the end", |it| it["state"] == "cancelled").await;
    until(&server, &second, "the next succeeds", has_succeeded).await;
    assert_eq!(get(&server, &path).await["progress"], ended["progress"], "it goes on no more");
    let removed = http::call(server.address, "DELETE", &path, &[], b"").await;
    assert_eq!(removed.code, 204, "{removed:?}");
    let gone = http::call(server.address, "GET", &path, &[], b"").await;
    assert_eq!(gone.code, 404, "{gone:?}");
}

/// Guards against: who asks again because the server died gets a second evolution.
#[tokio::test]
async fn a_key_means_one_evolution_also_after_the_server_was_killed() {
    let data = Data::new();
    let mut server = Server::start_with(&["--data", data.text()]);
    let first = post(&server, "/v1/evolutions", "key-1", &endless()).await;
    assert_eq!(first.code, 201, "{first:?}");
    server.process.kill();
    let mut server = Server::start_with(&["--data", data.text()]);
    let again = post(&server, "/v1/evolutions", "key-1", &endless()).await;
    assert_eq!(again.code, 200, "{again:?}");
    assert_eq!(again.json()["evolution"], "evolution-1");
    assert_eq!(again.json()["spec"], first.json()["spec"]);
    let other = post(&server, "/v1/evolutions", "key-1", &small(1)).await;
    assert_eq!(other.code, 409, "{other:?}");
    assert_eq!(other.json()["error"]["details"][0]["reason"], "IDEMPOTENCY_KEY_REUSED");
    let next = post(&server, "/v1/evolutions", "key-2", &endless()).await;
    assert_eq!((next.code, &next.json()["evolution"]), (201, &"evolution-2".into()));
    let cancelled = post(&server, "/v1/evolutions/evolution-2/cancel", "", "").await;
    assert_eq!(cancelled.code, 200, "{cancelled:?}");
    let removed =
        http::call(server.address, "DELETE", "/v1/evolutions/evolution-2", &[], b"").await;
    assert_eq!(removed.code, 204, "{removed:?}");
    server.process.kill();
    let server = Server::start_with(&["--data", data.text()]);
    let last = post(&server, "/v1/evolutions", "key-3", &small(1)).await;
    assert_eq!(last.json()["evolution"], "evolution-3", "a number never comes back");
}

/// Guards against: a champion that cannot be had again, or that depends on where it was looked for.
#[tokio::test]
async fn the_same_seed_gives_the_same_champion_everywhere() {
    let flags = small_flags(5);
    let first = evolve(&flags, EVOLUTION).await;
    assert_eq!(first["champion"], evolve(&flags, EVOLUTION).await["champion"], "twice");
    let one = evolve(&format!("{flags} --threads 1"), EVOLUTION).await;
    let two = evolve(&format!("{flags} --threads 2"), EVOLUTION).await;
    assert_eq!((&one["threads"], &two["threads"]), (&json!(1), &json!(2)));
    assert_eq!(first["champion"], one["champion"]);
    assert_eq!(first["champion"], two["champion"]);
    let server = Server::start();
    let path = submit(&server, &small(5)).await;
    let over_http = until(&server, &path, "it succeeds", has_succeeded).await;
    assert_eq!(first["champion"], over_http["champion"], "over HTTP");
    let other = evolve(&small_flags(6), EVOLUTION).await;
    assert_ne!(first["champion"], other["champion"], "another seed, another champion");
}

/// Guards against: the server waits for the evolution, or the evolution begins anew with the next server.
#[tokio::test]
async fn sigterm_in_the_middle_of_an_evolution_ends_the_server_soon_and_the_next_goes_on() {
    let data = Data::new();
    let mut server = Server::start_with(&["--data", data.text()]);
    let path = submit(&server, &endless()).await;
    until(&server, &path, "a generation", goes_on).await;
    server.process.signal(Signal::Terminate);
    let status = server.process.end(Duration::from_secs(3)).await;
    assert_eq!(status.code(), Some(0), "{}", server.process.log());

    let server = Server::start_with(&["--data", data.text()]);
    let found = get(&server, &path).await["progress"]["generation"].as_u64().unwrap();
    assert!(found > 0, "it begins anew");
    let farther = |it: &Value| it["progress"]["generation"].as_u64() > Some(found);
    let on = until(&server, &path, "the next generation", farther).await;
    assert_eq!((&on["interrupted"], &on["state"]), (&json!(1), &json!("running")));
}

/// Guards against: figures that no program opens, or that show nothing.
#[tokio::test]
async fn figures_are_files_that_programs_can_read() {
    let server = Server::start();
    let path = submit(&server, &small(1)).await;
    until(&server, &path, "it succeeds", has_succeeded).await;
    let folder = Data::new();
    let plotted =
        umwelt(&server, &format!("evolution plot evolution-1 --out {}", folder.text())).await;
    assert_eq!(plotted["files"].as_array().map(Vec::len), Some(2), "{plotted}");
    for name in ["evolution-1-deviation.svg", "evolution-1-time.svg"] {
        let text = fs::read_to_string(folder.file(name)).unwrap();
        let document =
            roxmltree::Document::parse(&text).unwrap_or_else(|error| panic!("{name}: {error}"));
        let root = document.root_element();
        assert_eq!(
            (root.tag_name().name(), root.tag_name().namespace()),
            ("svg", Some("http://www.w3.org/2000/svg"))
        );
        let lines = root
            .descendants()
            .filter(|node| ["polyline", "path"].contains(&node.tag_name().name()));
        assert!(lines.count() >= 2, "{name}: best and mean");
        assert!(text.contains("evolution-1") && text.contains("normal"), "{name}: {text}");
    }
    let url = server.url();
    let nothing = call(
        "umwelt",
        &["--server", &url, "evolution", "plot", "evolution-9", "--out", folder.text()],
    )
    .await;
    assert_eq!(nothing.code, Some(1), "{nothing:?}");
}
