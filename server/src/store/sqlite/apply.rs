//! Changes as SQL.

use crate::store::document::{self, prior, robot};
use crate::store::{Change, JobId, StoredJob};
use rusqlite::{Connection, params};
use umwelt_core::controller::STATE_VERSION;

/// Why a change is not made.
#[derive(Debug)]
pub(super) enum ApplyError {
    /// SQLite says no.
    Sqlite(rusqlite::Error),
    /// It cannot be written down.
    Unfit(String),
}

impl From<rusqlite::Error> for ApplyError {
    fn from(error: rusqlite::Error) -> Self {
        Self::Sqlite(error)
    }
}

impl From<document::Unfit> for ApplyError {
    fn from(unfit: document::Unfit) -> Self {
        Self::Unfit(unfit.to_string())
    }
}

/// Makes one change.
pub(super) fn apply(connection: &Connection, change: &Change) -> Result<(), ApplyError> {
    let run = |sql: &str, values: &[&dyn rusqlite::ToSql]| -> Result<(), ApplyError> {
        connection.prepare_cached(sql)?.execute(values)?;
        Ok(())
    };
    match change {
        Change::PutRobot(id, record) => {
            let revision = integer(record.revision)?;
            run(
                "DELETE FROM posteriors WHERE robot = ?1 \
                 AND EXISTS (SELECT 1 FROM robots WHERE id = ?1 AND revision <> ?2)",
                params![id.as_str(), revision],
            )?;
            run(
                "INSERT INTO robots (id, revision, body, checksum) \
                 VALUES (?1, ?2, ?3, row_checksum('robots', ?1, ?2, ?3)) \
                 ON CONFLICT (id) DO UPDATE SET revision = excluded.revision, \
                 body = excluded.body, checksum = excluded.checksum",
                params![id.as_str(), revision, robot::of_record(record)?],
            )
        }
        Change::DeleteRobot(id) => run("DELETE FROM robots WHERE id = ?1", params![id.as_str()]),
        Change::PutPosterior(id, posterior) => run(
            "INSERT INTO posteriors (robot, version, body, checksum) \
             SELECT id, ?3, ?4, row_checksum('posteriors', id, ?3, ?4) \
             FROM robots WHERE id = ?1 AND revision = ?2 \
             ON CONFLICT (robot) DO UPDATE SET version = excluded.version, \
             body = excluded.body, checksum = excluded.checksum",
            params![
                id.as_str(),
                integer(posterior.revision)?,
                STATE_VERSION,
                robot::of_saved(&posterior.saved)?
            ],
        ),
        Change::PutPrior(named) => run(
            "INSERT INTO priors (name, body, checksum) \
             VALUES (?1, ?2, row_checksum('priors', ?1, ?2)) \
             ON CONFLICT (name) DO UPDATE SET body = excluded.body, checksum = excluded.checksum",
            params![named.name, prior::of_prior(named)?],
        ),
        Change::DeletePrior(name) => run("DELETE FROM priors WHERE name = ?1", params![name]),
        Change::PutEnvironment(environment) => run(
            "INSERT INTO environments (name, body, checksum) \
             VALUES (?1, ?2, row_checksum('environments', ?1, ?2)) \
             ON CONFLICT (name) DO UPDATE SET body = excluded.body, checksum = excluded.checksum",
            params![environment.name, environment.body],
        ),
        Change::DeleteEnvironment(name) => {
            run("DELETE FROM environments WHERE name = ?1", params![name])
        }
        Change::PutJob(StoredJob { id: JobId { kind, number }, finished, body }) => {
            let number = integer(*number)?;
            run(
                "INSERT INTO jobs (kind, number, finished, body, checksum) \
                 VALUES (?1, ?2, ?3, ?4, row_checksum('jobs', ?1, ?2, ?3, ?4)) \
                 ON CONFLICT (kind, number) DO UPDATE SET finished = excluded.finished, \
                 body = excluded.body, checksum = excluded.checksum",
                params![kind.name(), number, finished, body],
            )?;
            run(
                "INSERT INTO last_numbers (kind, number, checksum) \
                 VALUES (?1, ?2, row_checksum('last_numbers', ?1, ?2)) \
                 ON CONFLICT (kind) DO UPDATE SET number = excluded.number, \
                 checksum = excluded.checksum WHERE excluded.number > number",
                params![kind.name(), number],
            )
        }
        Change::DeleteJob(JobId { kind, number }) => run(
            "DELETE FROM jobs WHERE kind = ?1 AND number = ?2",
            params![kind.name(), integer(*number)?],
        ),
        Change::PutPart { job: JobId { kind, number }, index, body } => run(
            "INSERT INTO parts (kind, number, position, body, checksum) \
             SELECT kind, number, ?3, ?4, row_checksum('parts', kind, number, ?3, ?4) \
             FROM jobs WHERE kind = ?1 AND number = ?2 \
             ON CONFLICT (kind, number, position) DO UPDATE SET body = excluded.body, \
             checksum = excluded.checksum",
            params![kind.name(), integer(*number)?, integer(*index as u64)?, body],
        ),
        Change::PutCheckpoint { job: JobId { kind, number }, body } => run(
            "INSERT INTO checkpoints (kind, number, body, checksum) \
             SELECT kind, number, ?3, row_checksum('checkpoints', kind, number, ?3) \
             FROM jobs WHERE kind = ?1 AND number = ?2 \
             ON CONFLICT (kind, number) DO UPDATE SET body = excluded.body, \
             checksum = excluded.checksum",
            params![kind.name(), integer(*number)?, body],
        ),
        Change::DeleteCheckpoint(JobId { kind, number }) => run(
            "DELETE FROM checkpoints WHERE kind = ?1 AND number = ?2",
            params![kind.name(), integer(*number)?],
        ),
    }
}

/// SQLite's integers have a sign.
fn integer(number: u64) -> Result<i64, ApplyError> {
    i64::try_from(number).map_err(|_| ApplyError::Unfit(format!("{number} is too large")))
}
