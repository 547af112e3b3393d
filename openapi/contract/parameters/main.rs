//! `docs/parameters.md` is what `openapi.json` says of every field that users send.
//!
//! The generator starts at the request bodies of the operations and follows each `$ref`. It knows no schema by its name.
//! `UPDATE_GOLDEN=1 cargo test -p umwelt-contract --test parameters` writes the file anew.

mod effects;
mod page;
mod unit;

use serde_json::Value;
use std::collections::BTreeSet;

const GOLDEN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/parameters.md");

fn document() -> Value {
    serde_json::to_value(umwelt_api::document()).expect("it is JSON")
}

#[test]
fn the_page_is_what_the_contract_says() {
    let now = page::page(&document());
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(GOLDEN, &now).unwrap();
    }
    let golden = std::fs::read_to_string(GOLDEN).unwrap_or_default();
    assert!(
        golden == now,
        "docs/parameters.md is stale: UPDATE_GOLDEN=1 cargo test -p umwelt-contract --test parameters"
    );
}

#[test]
fn every_effect_belongs_to_a_field() {
    let document = document();
    for effects in effects::EFFECTS {
        let fields = page::fields(&document, effects.body);
        let mut given = BTreeSet::new();
        for (field, _) in effects.fields {
            assert!(fields.contains(*field), "{} has no field {field}: {fields:?}", effects.body);
            assert!(given.insert(field), "{}: {field} is given twice", effects.body);
        }
    }
}

#[test]
fn every_body_is_on_the_page() {
    let document = document();
    let page = page::page(&document);
    for body in page::bodies(&document) {
        let heading = format!("\n## `{}`\n", body.operation);
        assert!(page.contains(&heading), "{heading} is missing");
    }
}
