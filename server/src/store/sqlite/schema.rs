//! The tables, and the way from older ones to them.
//!
//! `PRAGMA user_version` is the number of migrations made. A migration that was released is never changed: the next
//! change of the tables is one more. What is in a `body` has a version of its own (`document`).

use super::checksum;
use rusqlite::{Connection, TransactionBehavior};

/// "Umwt": by this a data file is told from any other SQLite database.
pub(super) const APPLICATION_ID: i32 = 0x556d_7774;

/// What leads from each version of the tables to the next, from none on.
pub(super) const MIGRATIONS: &[&str] =
    &[include_str!("version-1.sql"), include_str!("version-2.sql"), include_str!("version-3.sql")];

/// The first version of the tables whose rows have checksums.
pub(super) const CHECKSUMS: usize = 3;

/// What stands in the way of using a database.
#[derive(Debug, PartialEq)]
pub(super) enum Unusable {
    /// It is of something else.
    Foreign,
    /// It is of a newer program.
    Newer { version: usize },
    /// It does not hold together.
    Damaged(String),
    /// A file beside it went while it was being opened.
    Gone(String),
    /// SQLite says no.
    Failed(rusqlite::Error),
}

impl From<rusqlite::Error> for Unusable {
    fn from(error: rusqlite::Error) -> Self {
        Self::Failed(error)
    }
}

/// The version of the tables; none where there are no tables at all.
pub(super) fn version(connection: &Connection, newest: usize) -> Result<Option<usize>, Unusable> {
    let pragma = |name| connection.pragma_query_value(None, name, |row| row.get::<_, i32>(0));
    let (application, version) = (pragma("application_id")?, pragma("user_version")?);
    let count = "SELECT count(*) FROM sqlite_schema";
    let tables: i64 = connection.query_row(count, [], |row| row.get(0))?;
    if (application, version, tables) == (0, 0, 0) {
        return Ok(None);
    }
    match usize::try_from(version) {
        Ok(version) if application == APPLICATION_ID && version <= newest => Ok(Some(version)),
        Ok(version) if application == APPLICATION_ID => Err(Unusable::Newer { version }),
        _ => Err(Unusable::Foreign),
    }
}

/// Makes the tables those that `migrations` lead to, each step whole or not at all. Returns the version before.
pub(super) fn migrate(connection: &mut Connection, migrations: &[&str]) -> Result<usize, Unusable> {
    let before = version(connection, migrations.len())?.unwrap_or(0);
    for (done, migration) in migrations.iter().enumerate().skip(before) {
        let step = connection.transaction_with_behavior(TransactionBehavior::Immediate)?;
        step.execute_batch(migration)?;
        step.pragma_update(None, "application_id", APPLICATION_ID)?;
        step.pragma_update(None, "user_version", done as i64 + 1)?;
        step.commit()?;
    }
    Ok(before)
}

/// Whether the tables are those that `migrations` lead to: a name or a type that has changed on the disk would make the
/// rows mean something else.
pub(super) fn check_shape(connection: &Connection, migrations: &[&str]) -> Result<(), Unusable> {
    let mut fresh = Connection::open_in_memory()?;
    checksum::install(&fresh)?;
    migrate(&mut fresh, migrations)?;
    let is_same = shape(connection)? == shape(&fresh)?;
    is_same
        .then_some(())
        .ok_or_else(|| Unusable::Damaged("its tables are not as they were made".to_owned()))
}

/// Every column of every table and every reference between tables, in words.
fn shape(connection: &Connection) -> rusqlite::Result<Vec<String>> {
    let mut select = connection.prepare(
        "SELECT concat_ws(' ', t.name, t.wr, t.strict, c.name, c.type, c.\"notnull\", c.pk, c.dflt_value) \
         FROM pragma_table_list AS t JOIN pragma_table_xinfo(t.name) AS c \
         WHERE t.schema = 'main' AND t.type = 'table' \
         UNION ALL SELECT concat_ws(' ', t.name, f.\"table\", f.\"from\", f.\"to\", f.on_delete) \
         FROM pragma_table_list AS t JOIN pragma_foreign_key_list(t.name) AS f \
         WHERE t.schema = 'main' AND t.type = 'table' ORDER BY 1",
    )?;
    let lines = select.query_map([], |row| row.get(0))?;
    lines.collect()
}
