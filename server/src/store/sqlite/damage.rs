//! Rows that are not as they were written: found, named, and taken out.

use super::tables::{self, CHECKPOINTS, PARTS, Table};
use rusqlite::types::ValueRef;
use rusqlite::{Connection, Row};
use std::fmt;
use std::path::Path;

/// Most rows that one message names.
const NAMED: usize = 10;

/// What is said of a row whose checksum is another one.
const CHANGED: &str = "its checksum does not match: it is not what was written";

/// A row that is damaged.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Damage {
    /// Its table.
    pub table: &'static str,
    /// Its key, as far as that can be read: the columns of it, with `/` between them.
    pub key: String,
    /// What is wrong with it.
    pub why: String,
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { table, key, why } = self;
        write!(f, "{table} {key} ({why})")
    }
}

impl Damage {
    /// The row that `row` is, which [`Table::select`] has brought.
    pub(super) fn of(table: &Table, row: &Row<'_>, why: impl fmt::Display) -> Self {
        let key = (0..table.key.len()).map(|index| said(row, index)).collect::<Vec<_>>().join("/");
        Self { table: table.name, key, why: why.to_string() }
    }

    /// The same where the checksum says that it was changed, none otherwise.
    pub(super) fn changed(table: &Table, row: &Row<'_>) -> Option<Self> {
        // What is no number is no yes.
        let is_whole = row.get::<_, bool>(table.width()).unwrap_or(false);
        (!is_whole).then(|| Self::of(table, row, CHANGED))
    }
}

fn said(row: &Row<'_>, index: usize) -> String {
    match row.get_ref(index) {
        Ok(ValueRef::Text(text)) => {
            String::from_utf8_lossy(text).chars().flat_map(char::escape_debug).collect()
        }
        Ok(ValueRef::Integer(integer)) => integer.to_string(),
        _ => "?".to_owned(),
    }
}

/// What it means that rows of `file` are damaged, and what to do.
pub(super) fn message(file: &Path, damaged: &[Damage]) -> String {
    let mut rows: Vec<String> = damaged.iter().take(NAMED).map(ToString::to_string).collect();
    if damaged.len() > NAMED {
        rows.push(format!("and {} more", damaged.len() - NAMED));
    }
    let directory = file.parent().unwrap_or(Path::new(".")).display();
    format!(
        "{} in {}: {}; end the server and put a backup in its place, or give up these rows alone: \
         umwelt-server check --data {directory} --remove-damaged",
        if damaged.len() == 1 { "a row" } else { "rows" },
        file.display(),
        rows.join(", "),
    )
}

/// Every damaged row of every table, those included that are only read when someone asks.
pub(super) fn scan(connection: &Connection) -> rusqlite::Result<Vec<Damage>> {
    let mut damaged = Vec::new();
    for table in tables::ALL {
        let mut select = connection.prepare(&table.select(""))?;
        let mut rows = select.query([])?;
        while let Some(row) = rows.next()? {
            damaged.extend(Damage::changed(table, row));
        }
    }
    Ok(damaged)
}

/// Takes out every row that [`scan`] finds, a robot with what it learned, and a job with everything of it where one of
/// its parts or its checkpoint is damaged.
pub(super) fn remove(connection: &Connection) -> rusqlite::Result<()> {
    for table in [&PARTS, &CHECKPOINTS] {
        let (name, is_whole) = (table.name, table.is_whole());
        let of_job = format!(
            "DELETE FROM jobs WHERE (kind, number) IN \
             (SELECT kind, number FROM {name} WHERE NOT {is_whole})"
        );
        connection.execute(&of_job, [])?;
    }
    for table in tables::ALL {
        let (name, is_whole) = (table.name, table.is_whole());
        connection.execute(&format!("DELETE FROM {name} WHERE NOT {is_whole}"), [])?;
    }
    Ok(())
}
