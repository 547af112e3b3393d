//! A data file of an earlier version of the program, and one that a later version has written into.

use crate::api::{Answer, Api, JSON, config};
use rusqlite::Connection;
use serde_json::{Value, json};
use std::path::Path;
use std::sync::Arc;
use tempfile::{TempDir, tempdir};
use umwelt_server::store::{DATA_FILE, SqliteStore};

/// What version 0.1.0 kept, and what it showed of it.
fn version_0_1_0() -> (TempDir, Value) {
    let directory = tempdir().unwrap();
    let file = Connection::open(directory.path().join(DATA_FILE)).unwrap();
    file.execute_batch(include_str!("store-0.1.0.sql")).unwrap();
    (directory, serde_json::from_str(include_str!("store-0.1.0.json")).unwrap())
}

async fn serve(directory: &Path) -> (Api, Arc<SqliteStore>) {
    let store = Arc::new(SqliteStore::open(directory).unwrap());
    (Api::with(config(), store.clone()).await, store)
}

/// The items of a list that have ended or never begin.
fn settled(page: &Value, list: &str) -> Vec<Value> {
    let goes_on = |item: &&Value| item["state"] == "running" || item["state"] == "queued";
    page[list].as_array().unwrap().iter().filter(|item| !goes_on(item)).cloned().collect()
}

/// What `now` has of the fields that were there `before`: answers only gain fields.
fn without_additions(now: &Value, before: &Value) -> Value {
    match (now, before) {
        (Value::Object(now), Value::Object(before)) => {
            let kept = now.iter().filter_map(|(name, value)| {
                Some((name.clone(), without_additions(value, before.get(name)?)))
            });
            kept.collect()
        }
        (Value::Array(now), Value::Array(before)) if now.len() == before.len() => {
            now.iter().zip(before).map(|(now, before)| without_additions(now, before)).collect()
        }
        _ => now.clone(),
    }
}

#[tokio::test]
async fn a_store_of_version_0_1_0_opens_with_everything_in_it() {
    let (directory, before) = version_0_1_0();
    let (api, _store) = serve(directory.path()).await;
    for (path, list, count) in [
        ("/v1/priors", "priors", 8),
        ("/v1/environments", "environments", 8),
        ("/v1/evolutions", "evolutions", 4),
        ("/v1/comparisons", "comparisons", 2),
    ] {
        let now = api.get(path).await.json();
        let expected = Value::from(settled(&before[path], list));
        let found = without_additions(&settled(&now, list).into(), &expected);
        assert_eq!(found, expected, "{path}");
        assert_eq!(now[list].as_array().unwrap().len(), count, "{path}");
        assert_eq!(now.get("unreadable"), None, "{path}");
        let specs = |page: &Value| -> Vec<Value> {
            page[list].as_array().unwrap().iter().map(|item| item["spec"].clone()).collect()
        };
        assert_eq!(specs(&now), specs(&before[path]), "{path}");
    }
    for path in [
        "/v1/evolutions/evolution-1",
        "/v1/evolutions/evolution-1/generations",
        "/v1/comparisons/comparison-1",
    ] {
        let now = api.get(path).await.json();
        assert_eq!(without_additions(&now, &before[path]), before[path], "{path}");
    }
    let robots = api.get("/v1/robots").await.json();
    for (robot, before) in robots["robots"]
        .as_array()
        .unwrap()
        .iter()
        .zip(before["/v1/robots"]["robots"].as_array().unwrap())
    {
        for field in ["robot", "spec", "stopped"] {
            let now = without_additions(&robot[field], &before[field]);
            assert_eq!(now, before[field], "{field} of {}", before["robot"]);
        }
        // It was described before anything followed from the rest: all of it stays.
        let mut all = robot["spec"].clone();
        // Of one kind alone, it was not said which.
        for name in ["kind", "turn_by_speed_s_per_m", "sideways_m_per_rad"] {
            all["drive"].as_object_mut().unwrap().remove(name);
        }
        assert_eq!(robot["described"], all);
    }
    assert_eq!(robots["robots"].as_array().unwrap().len(), 3);
    for path in ["/v1/robots/own/task", "/v1/robots/burger/task"] {
        let task = api.get(path).await.json();
        assert_eq!((&task["spec"], &task["etag"]), (&before[path]["spec"], &before[path]["etag"]));
        assert_eq!(task["progress"]["leg"], before[path]["progress"]["leg"], "{path}");
    }
    let path = "/v1/robots/burger/environment";
    let learned = api.get(path).await.json();
    for channel in ["forward", "lateral", "turn", "drift"] {
        let channel = format!("/channels/{channel}");
        let (now, then) = (learned.pointer(&channel), before[path].pointer(&channel));
        let (now, then) = (now.unwrap(), then.unwrap());
        assert_eq!(&without_additions(now, then), then, "{channel}");
    }
    assert_eq!(without_additions(&learned["link"], &before[path]["link"]), before[path]["link"]);
}

/// Writes a body with its checksum, as another version of the program would.
fn write(directory: &Path, table: &str, key: &str, body: &str) {
    let file = Connection::open(directory.join(DATA_FILE)).unwrap();
    let columns: Vec<String> = file
        .prepare(&format!("SELECT name FROM pragma_table_info('{table}') WHERE name <> 'checksum'"))
        .unwrap()
        .query_map([], |row| row.get(0))
        .unwrap()
        .collect::<Result<_, _>>()
        .unwrap();
    let set = format!("UPDATE {table} SET body = ?1 WHERE {key}");
    assert_eq!(file.execute(&set, [body]).unwrap(), 1, "{table} {key}");
    let read = format!("SELECT {} FROM {table} WHERE {key}", columns.join(", "));
    let checksum = file
        .query_row(&read, [], |row| {
            let values = (0..columns.len()).map(|index| row.get_ref(index).unwrap());
            Ok(checksum(table, values))
        })
        .unwrap();
    file.execute(&format!("UPDATE {table} SET checksum = ?1 WHERE {key}"), [checksum]).unwrap();
}

/// The checksum of a row, as docs/store.md and the store's tests have it.
fn checksum<'a>(
    table: &'a str,
    values: impl Iterator<Item = rusqlite::types::ValueRef<'a>>,
) -> i64 {
    use rusqlite::types::ValueRef;
    let crc = crc::Crc::<u64>::new(&crc::CRC_64_XZ);
    let mut digest = crc.digest();
    for value in std::iter::once(ValueRef::Text(table.as_bytes())).chain(values) {
        let (kind, number, bytes): (u8, u64, &[u8]) = match value {
            ValueRef::Null => (0, 0, &[]),
            ValueRef::Integer(integer) => (1, integer.cast_unsigned(), &[]),
            ValueRef::Real(real) => (2, real.to_bits(), &[]),
            ValueRef::Text(text) => (3, text.len() as u64, text),
            ValueRef::Blob(blob) => (4, blob.len() as u64, blob),
        };
        digest.update(&[kind]);
        digest.update(&number.to_le_bytes());
        digest.update(bytes);
    }
    digest.finalize().cast_signed()
}

fn refused(answer: &Answer) -> Value {
    assert_eq!(answer.code, 409, "{answer:?}");
    let error = &answer.json()["error"];
    assert_eq!(error["status"], "FAILED_PRECONDITION");
    assert_eq!(error["details"][0]["reason"], "UNREADABLE");
    error.clone()
}

/// Guards against a server that does not start, or a list that lacks what a later version of the program has written.
#[tokio::test]
async fn what_a_later_version_wrote_keeps_its_place_as_unreadable() {
    let (directory, _) = version_0_1_0();
    drop(SqliteStore::open(directory.path()).unwrap());
    let later = r#"{"version": 99, "program": "7.0.0", "content": {}}"#;
    let rows = [
        ("robots", "id = 'own'", "robots", "own"),
        ("priors", "name = 'meadow'", "priors", "meadow"),
        ("environments", "name = 'odd'", "environments", "odd"),
        ("jobs", "kind = 'evolution' AND number = 1", "evolutions", "evolution-1"),
        ("jobs", "kind = 'comparison' AND number = 1", "comparisons", "comparison-1"),
    ];
    for (table, key, _, _) in rows {
        write(directory.path(), table, key, later);
    }
    let (api, store) = serve(directory.path()).await;
    for (_, _, list, name) in rows {
        let path = format!("/v1/{list}");
        let page = api.get(&path).await.json();
        let unreadable = page["unreadable"].as_array().unwrap();
        assert_eq!(unreadable.len(), 1, "{page}");
        assert_eq!(
            (&unreadable[0]["name"], &unreadable[0]["written_by"]),
            (&json!(name), &json!("7.0.0"))
        );
        assert!(
            unreadable[0]["remedy"].as_str().unwrap().contains(&format!("DELETE {path}/{name}"))
        );
        assert!(!page[list].as_array().unwrap().is_empty(), "the others are there");
        let error = refused(&api.get(&format!("{path}/{name}")).await);
        let said = error["message"].as_str().unwrap();
        assert!(said.contains("written by version 7.0.0"), "{said}");
    }
    refused(&api.call("POST", "/v1/robots/own/step", &[JSON], "{}").await);
    // Its place in the list is that of its name.
    let page = api.get("/v1/robots?page_size=1").await.json();
    assert_eq!((&page["robots"][0]["robot"], page.get("unreadable")), (&json!("burger"), None));
    let token = page["next_page_token"].as_str().unwrap();
    let page = api.get(&format!("/v1/robots?page_size=1&page_token={token}")).await.json();
    assert_eq!(page["unreadable"][0]["name"], "own");
    // No champion takes a name that is taken.
    let wish = json!({"preset": "quick", "prior": "meadow"}).to_string();
    let taken = api.call("POST", "/v1/evolutions", &[JSON], wish).await;
    assert_eq!(taken.json()["error"]["details"][0]["reason"], "NAME_TAKEN", "{taken:?}");

    // What is put in its place is there, and what is removed is gone, for good.
    assert_eq!(api.put("/v1/robots/own", json!({})).await.code, 201);
    for (_, _, list, name) in &rows[1..] {
        let path = format!("/v1/{list}/{name}");
        assert_eq!(api.call("DELETE", &path, &[], "").await.code, 204, "{path}");
        assert_eq!(api.get(&path).await.code, 404, "{path}");
    }
    let contents = umwelt_server::Store::load(&*store).unwrap();
    assert_eq!(contents.unreadable, []);
    assert_eq!(contents.robots.len(), 3);
}
