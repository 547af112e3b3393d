//! The rooms of the crate: each names those below it and none above, and only `http` and what is above it know HTTP.

use std::fs;
use std::path::{Path, PathBuf};

/// From the top down.
const ROOMS: [&str; 7] = ["program", "http", "jobs", "fleet", "library", "store", "resource"];

/// The crates that only `http` and what is above it may name.
const OF_HTTP: [&str; 3] = ["axum::", "hyper_util::", "tower_http::"];

/// Every file with code under `folder` but those that are tests.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let is_test = |path: &PathBuf| path.file_stem().is_some_and(|name| name == "tests");
    let (folders, files): (Vec<_>, Vec<_>) =
        entries.filter(|path| !is_test(path)).partition(|path| path.is_dir());
    let files = files.into_iter().filter(|path| path.extension().is_some_and(|it| it == "rs"));
    files.chain(folders.iter().flat_map(|folder| sources(folder))).collect()
}

/// The code of a file without its tests and its comments.
fn code(file: &Path) -> String {
    let text = fs::read_to_string(file).unwrap();
    let text = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
    text.lines().filter(|line| !line.trim_start().starts_with("//")).collect()
}

/// The rooms that `code` names.
fn named(code: &str) -> Vec<&'static str> {
    let paths: Vec<_> = code.split("crate::").skip(1).collect();
    let is_named = |room: &str| {
        paths.iter().any(|path| path.strip_prefix(room).is_some_and(|rest| rest.starts_with("::")))
    };
    ROOMS.into_iter().filter(|room| is_named(room)).collect()
}

#[test]
fn no_room_names_one_above_it() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut upward = Vec::new();
    for (place, room) in ROOMS.iter().enumerate() {
        let files = sources(&source.join(room));
        assert!(!files.is_empty(), "{room} is empty");
        for file in files {
            let code = code(&file);
            let name = file.strip_prefix(&source).unwrap().to_str().unwrap().to_owned();
            assert!(
                !code.contains("crate::{"),
                "{name}: name the room first, as in crate::store::"
            );
            let above = named(&code).into_iter().filter(|named| ROOMS[..place].contains(named));
            upward.extend(above.map(|above| (name.clone(), above)));
            if place > 1 {
                let found = OF_HTTP.iter().find(|of_http| code.contains(*of_http));
                assert_eq!(found, None, "{name} is below http");
            }
        }
    }
    assert_eq!(upward, [], "arrows upward");
}
