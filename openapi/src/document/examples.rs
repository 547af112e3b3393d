//! One example of everything that is sent and answered, by the name of its schema: what a server and its robots said.

use serde_json::Value;
use std::sync::LazyLock;

/// Read once for the whole document. A test reads each of them, so it is JSON.
static EXAMPLES: LazyLock<Value> =
    LazyLock::new(|| serde_json::from_str(include_str!("examples.json")).unwrap_or_default());

/// The example of the schema of this name.
pub(super) fn of(name: &str) -> Option<Value> {
    EXAMPLES.get(name).cloned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::endpoint::{self, Answer, Schemas};

    /// Guards against an example that is none, or is missing.
    #[test]
    fn every_body_and_every_answer_has_an_example_that_is_one() {
        for operation in endpoint::all() {
            if let Some((wire, max_bytes, _)) = operation.body {
                let name = wire.schema(&mut Schemas::new()).0;
                let example = of(&name).unwrap_or_else(|| panic!("{operation}: no body"));
                assert!(wire.again(&example).is_ok(), "{operation}: {example}");
                assert!(example.to_string().len() <= max_bytes);
            }
            if let Answer::Json(wire, _) | Answer::Created(wire, _) = operation.answer {
                let name = wire.schema(&mut Schemas::new()).0;
                let example = of(&name).unwrap_or_else(|| panic!("{operation}: no answer"));
                assert_eq!(wire.again(&example).as_ref(), Ok(&example), "{operation}");
            }
        }
    }
}
