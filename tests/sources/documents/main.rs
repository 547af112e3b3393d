//! What people read holds together: links lead somewhere, the commands of README are there, examples are listed, and what
//! the code cites of the thesis can be looked up.

mod citation;
mod markdown;
mod tree;

use citation::Citation;
use markdown::Page;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The page that has the thesis's equations, tables and figures.
const METHOD: &str = "docs/method.md";
/// The index of the documentation.
const INDEX: &str = "docs/README.md";
/// The index of the examples.
const EXAMPLES: &str = "docs/examples.md";
/// The two commands of README: the demo and the tests.
const COMMANDS: [&str; 2] = ["cargo run --release --example fleet", "bash tests/run.sh"];

fn page(path: &str) -> Page {
    Page::new(&tree::read(path))
}

#[test]
fn relative_links_and_their_anchors_lead_somewhere() {
    let mut wrong = Vec::new();
    for path in tree::files("md") {
        for target in Page::new(&tree::read(&path)).links {
            if let Err(why) = follow(&path, &target) {
                wrong.push(format!("{path}: {target}: {why}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Whether a link of the page at `from` leads to a file, and to a heading of it where it names one.
fn follow(from: &str, target: &str) -> Result<(), String> {
    if target.contains("://") || target.starts_with("mailto:") {
        return Ok(());
    }
    let (file, anchor) = match target.split_once('#') {
        Some((file, anchor)) => (file, Some(anchor)),
        None => (target, None),
    };
    let to = if file.is_empty() {
        PathBuf::from(from)
    } else {
        Path::new(from).parent().unwrap_or(Path::new("")).join(file)
    };
    let to = tree::root().join(to);
    if !to.exists() {
        return Err("there is no such file".to_owned());
    }
    let Some(anchor) = anchor else { return Ok(()) };
    let text = std::fs::read_to_string(&to).map_err(|error| error.to_string())?;
    let anchors = Page::new(&text).anchors;
    if anchors.contains(anchor) { Ok(()) } else { Err("there is no such heading".to_owned()) }
}

#[test]
fn readme_has_its_two_commands_and_continuous_integration_runs_the_second() {
    let shell: Vec<String> = page("README.md")
        .fences
        .into_iter()
        .filter(|fence| fence.language == "sh")
        .map(|fence| fence.text.trim().to_owned())
        .collect();
    assert_eq!(shell, COMMANDS, "README has one shell block for each command and no other");
    let ci = tree::read(".ci/run");
    assert!(ci.contains(COMMANDS[1]), ".ci/run does not run {}", COMMANDS[1]);
}

#[test]
fn every_example_is_in_the_index() {
    let links: BTreeSet<String> = page(EXAMPLES).links.into_iter().collect();
    let examples: Vec<String> = tree::files("rs").into_iter().filter(|it| is_example(it)).collect();
    assert!(examples.len() > 10, "{examples:?}");
    for example in examples {
        assert!(links.contains(&format!("../{example}")), "{EXAMPLES} does not have {example}");
    }
}

/// Whether `path` is the root of an example: `examples/name.rs` or `examples/name/main.rs`.
fn is_example(path: &str) -> bool {
    let Some((_, inner)) = path.split_once("/examples/") else { return false };
    inner.strip_suffix("/main.rs").unwrap_or(inner).split('/').count() == 1
}

#[test]
fn every_path_that_contributors_are_sent_to_exists() {
    let code = page("CONTRIBUTING.md").code;
    // A file or a folder from the root on; not a command, a pattern or a name beside another file.
    let is_path = |code: &str| {
        code.contains('/')
            && !code.contains([' ', '*'])
            && [".rs", ".md", ".json", "/"].iter().any(|ending| code.ends_with(ending))
            && code != "name/mod.rs"
    };
    let paths: Vec<_> = code.iter().filter(|code| is_path(code)).collect();
    assert!(paths.len() > 30, "{paths:?}");
    for path in paths {
        assert!(tree::root().join(path).exists(), "CONTRIBUTING.md names {path}: it is not there");
    }
}

#[test]
fn every_page_of_the_documentation_is_in_its_index() {
    let links: BTreeSet<String> = page(INDEX).links.into_iter().collect();
    for path in tree::files("md") {
        let Some(name) = path.strip_prefix("docs/") else { continue };
        assert!(path == INDEX || links.contains(name), "{INDEX} does not have {name}");
    }
}

#[test]
fn what_the_code_cites_of_the_thesis_can_be_looked_up() {
    let known: BTreeSet<Citation> = page(METHOD)
        .first_cells
        .iter()
        .flat_map(|cell| citation::citations(&cell.to_lowercase()))
        .collect();
    assert!(known.len() > 50, "{known:?}");
    let mut missing = Vec::new();
    for path in tree::files("rs") {
        if path.starts_with("tests/sources/documents/") {
            continue;
        }
        let text = citation::in_one_line(&tree::read(&path)).to_lowercase();
        for cited in citation::citations(&text) {
            if !known.contains(&cited) {
                missing.push(format!("{path}: {cited}"));
            }
        }
    }
    assert!(missing.is_empty(), "not in {METHOD}:\n{}", missing.join("\n"));
}

#[test]
fn no_page_is_left_that_nothing_leads_to() {
    let mut open = vec![String::from("README.md")];
    let mut reached: BTreeSet<String> = open.iter().cloned().collect();
    while let Some(path) = open.pop() {
        for target in page(&path).links {
            let file = target.split('#').next().unwrap_or_default();
            let is_page = file.ends_with(".md") && !file.contains("://");
            let parent = Path::new(&path).parent().unwrap_or(Path::new(""));
            let to = tree::normal(&parent.join(file));
            if is_page && tree::root().join(&to).exists() && reached.insert(to.clone()) {
                open.push(to);
            }
        }
    }
    for path in tree::files("md") {
        assert!(reached.contains(&path), "no link leads from README to {path}");
    }
}
