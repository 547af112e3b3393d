//! Who may import whom, read from `cargo metadata`: an arrow the wrong way fails here, not in review.

use crate::metadata::{list, metadata, text};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

/// The packages of the workspace and which of them each may depend on, dev-dependencies included.
const ALLOWED: [(&str, &[&str]); 11] = [
    ("umwelt-core", &[]),
    ("umwelt-api", &["umwelt-core", "umwelt-no-schema"]),
    ("umwelt-no-schema", &[]),
    ("umwelt-contract", &["umwelt-api"]),
    ("umwelt-lab", &["umwelt-core", "umwelt-api"]),
    ("umwelt-memory", &[]),
    ("umwelt-sources", &[]),
    ("umwelt-server", &["umwelt-core", "umwelt-api", "umwelt-lab", "umwelt-memory"]),
    ("umwelt-client", &["umwelt-api", "umwelt-core"]),
    ("umwelt-agent", &["umwelt-core", "umwelt-client"]),
    (
        "umwelt-tests",
        &[
            "umwelt-core",
            "umwelt-api",
            "umwelt-lab",
            "umwelt-server",
            "umwelt-client",
            "umwelt-agent",
        ],
    ),
];

/// Crates that do I/O, read clocks, or speak JSON: none of them may become a dependency of core.
const NOT_IN_CORE: [&str; 10] = [
    "tokio",
    "axum",
    "hyper",
    "reqwest",
    "serde_json",
    "tracing",
    "chrono",
    "time",
    "rayon",
    "rusqlite",
];

/// Direct dependencies of every package, with their kind (`normal`, `dev`, `build`).
fn dependencies() -> BTreeMap<String, BTreeSet<(String, String)>> {
    list(&metadata()["packages"])
        .iter()
        .map(|package| {
            let direct = list(&package["dependencies"]).iter();
            let direct = direct.map(|it| (text(&it["name"]).to_owned(), kind(it))).collect();
            (text(&package["name"]).to_owned(), direct)
        })
        .collect()
}

/// The kind of a dependency; cargo says null for a normal one.
fn kind(dependency: &Value) -> String {
    dependency["kind"].as_str().unwrap_or("normal").to_owned()
}

#[test]
fn every_arrow_points_inward() {
    let all = dependencies();
    let known: BTreeSet<&str> = ALLOWED.iter().map(|(name, _)| *name).collect();
    assert_eq!(all.keys().map(String::as_str).collect::<BTreeSet<_>>(), known);
    for (package, allowed) in ALLOWED {
        for (dependency, _) in &all[package] {
            let ours = known.contains(dependency.as_str());
            assert!(
                !ours || allowed.contains(&dependency.as_str()),
                "{package} must not depend on {dependency}"
            );
        }
    }
}

#[test]
fn core_depends_on_nothing_that_does_io() {
    for (dependency, kind) in &dependencies()["umwelt-core"] {
        let pure = kind != "normal" || !NOT_IN_CORE.contains(&dependency.as_str());
        assert!(pure, "core must not depend on {dependency}");
    }
}

#[test]
fn axum_and_rusqlite_stay_in_the_server_and_reqwest_in_the_client() {
    for (package, direct) in dependencies() {
        for (dependency, _) in direct {
            assert!(dependency != "axum" || package == "umwelt-server", "axum in {package}");
            // The tests hold the server's store against it.
            let may_have_store = ["umwelt-server", "umwelt-tests"].contains(&package.as_str());
            assert!(dependency != "rusqlite" || may_have_store, "rusqlite in {package}");
            assert!(dependency != "reqwest" || package == "umwelt-client", "reqwest in {package}");
        }
    }
}

/// Guards against a first build that makes the document: features of all default members are switched on together.
#[test]
fn schemas_are_made_for_tests_of_the_contract_alone() {
    let metadata = metadata();
    let makes_schemas = |package: &&Value| {
        let has =
            |dependency: &Value| list(&dependency["features"]).iter().any(|it| it == "document");
        list(&package["dependencies"]).iter().any(has)
    };
    let makers: Vec<_> = list(&metadata["packages"]).iter().filter(makes_schemas).collect();
    assert_eq!(makers.len(), 1);
    assert_eq!(text(&makers[0]["name"]), "umwelt-contract");
    let defaults = list(&metadata["workspace_default_members"]);
    assert!(
        !defaults.contains(&makers[0]["id"]),
        "umwelt-contract must not be built with the rest"
    );
}
