//! What a list holds and the server cannot read: shown below it.

use std::fmt::Write;
use umwelt_api::page::Unreadable;

/// The list with what cannot be read below it.
pub(super) fn with(mut list: String, unreadable: &[Unreadable]) -> String {
    for Unreadable { name, written_by, why, remedy } in unreadable {
        let by =
            written_by.as_ref().map_or_else(String::new, |it| format!(", written by version {it}"));
        // Writing to a String cannot fail.
        let _ = write!(list, "\n{name}: unreadable{by}: {why}; {remedy}");
    }
    list.trim_start().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_read_stands_below_the_list() {
        let newer = Unreadable {
            name: "r9".to_owned(),
            written_by: Some("0.3.0".to_owned()),
            why: "its form is of version 4".to_owned(),
            remedy: "use that".to_owned(),
        };
        let line = "r9: unreadable, written by version 0.3.0: its form is of version 4; use that";
        assert_eq!(
            with("ROBOT".to_owned(), std::slice::from_ref(&newer)),
            format!("ROBOT\n{line}")
        );
        assert_eq!(with(String::new(), &[newer]), line);
        assert_eq!(with("ROBOT".to_owned(), &[]), "ROBOT");
    }
}
