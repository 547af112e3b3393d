//! What the files of each crate name of each other, read from their sources: a circle of two files or an arrow to a
//! higher layer fails here, not in review, and so does a file that has grown too long. Which crate may import which is
//! in `layering`.
//!
//! A file names another where a path or a `use` in it leads to an item that the other one defines; re-exports are
//! followed to where the item is. What a module declares, and what it shows of its own modules, does not count. Neither do
//! documentation and tests. `cargo test -p umwelt-sources --test imports -- --nocapture` prints the counts.

mod graph;
mod known;
mod layering;
mod layers;
mod metadata;
mod names;
mod package;
mod tree;

use package::Package;
use std::collections::BTreeSet;
use std::fmt::Debug;

/// A file of production code has fewer lines than this, its tests included where they are in it.
const MOST_LINES: usize = 400;

/// What is new in `found` against what is known of `package`, and what is no longer true, in lines.
fn compare<T: Ord + Debug>(
    package: &Package,
    what: &str,
    found: impl IntoIterator<Item = T>,
    known: &[(&str, &[T])],
) -> Vec<String> {
    let found: BTreeSet<T> = found.into_iter().collect();
    let known = known.iter().filter(|(name, _)| *name == package.name);
    let known: BTreeSet<&T> = known.flat_map(|(_, entries)| *entries).collect();
    let new = found.iter().filter(|it| !known.contains(it));
    let new = new.map(|it| format!("{}: new {what}: {it:?}", package.name));
    let gone = known.iter().filter(|it| !found.contains(**it));
    let gone = gone.map(|it| format!("{}: strike from known.rs: {what} {it:?}", package.name));
    new.chain(gone).collect()
}

/// Fails with all that is wrong.
fn nothing_of(wrong: Vec<String>) {
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    let mut wrong = Vec::new();
    for package in package::all() {
        let circles = package.graph.circles();
        let in_table = circles.iter().map(Vec::as_slice);
        let news = compare(&package, "circle of imports", in_table, known::CIRCLES);
        if !news.is_empty() {
            wrong.extend(circles.iter().map(|circle| package.graph.between(circle)));
        }
        wrong.extend(news);
        let (files, edges) = (package.production.len(), package.graph.len());
        println!(
            "{:14} {files:4} files {edges:4} imports {:3} circles",
            package.name,
            circles.len()
        );
    }
    nothing_of(wrong);
}

#[test]
fn no_import_points_to_a_higher_layer() {
    let mut wrong = Vec::new();
    for package in package::all() {
        let of_package = layers::LAYERS.iter().find(|(name, _)| *name == package.name);
        let Some((_, layers)) = of_package else {
            wrong.push(format!("{}: has no layers", package.name));
            continue;
        };
        let homeless =
            package.production.iter().filter(|file| layers::rank(layers, file).is_none());
        wrong.extend(homeless.map(|file| format!("{}: {file} is in no layer", package.name)));
        let upward = layers::upward(&package.graph, layers);
        println!("{:14} {:3} layers {:3} upward imports", package.name, layers.len(), upward.len());
        wrong.extend(upward);
    }
    nothing_of(wrong);
}

#[test]
fn a_crate_that_stands_for_a_subject_is_named_where_that_belongs() {
    let mut wrong = Vec::new();
    for package in package::all() {
        for (_, crates, homes) in layers::SUBJECTS.iter().filter(|it| it.0 == package.name) {
            let elsewhere = package.production.iter().filter(|file| {
                !homes.iter().any(|home| file.as_str() == *home || file.starts_with(*home))
            });
            for file in elsewhere {
                let code = package.code(file);
                let named = crates.iter().filter(|name| code.contains(&format!("{name}::")));
                wrong.extend(named.map(|name| format!("{}: {file} names {name}", package.name)));
            }
        }
    }
    nothing_of(wrong);
}

#[test]
fn no_file_is_long() {
    let long = |package: &Package| {
        let files = package.production.iter().map(String::as_str);
        let long = files.filter(|file| package.lines(file) >= MOST_LINES);
        compare(package, "file of 400 lines or more", long, known::LONG)
    };
    nothing_of(package::all().iter().flat_map(long).collect());
}

#[test]
fn a_module_with_files_of_its_own_is_in_their_folder() {
    let beside = |package: &Package| {
        let is_beside = |file: &&String| {
            let folder = format!("{}/", file.trim_end_matches(".rs"));
            package.files.keys().any(|other| other.starts_with(&folder))
        };
        let beside = package.production.iter().filter(is_beside);
        let beside = beside.map(|file| format!("{}: {file} is beside its folder", package.name));
        beside.collect::<Vec<_>>()
    };
    nothing_of(package::all().iter().flat_map(beside).collect());
}

#[test]
fn every_package_of_a_table_is_one_of_the_workspace() {
    let packages = package::all();
    let circles = known::CIRCLES.iter().map(|(name, _)| *name);
    let long = known::LONG.iter().map(|(name, _)| *name);
    for name in layers::LAYERS.iter().map(|(name, _)| *name).chain(circles).chain(long) {
        assert!(packages.iter().any(|package| package.name == name), "{name}");
    }
}
