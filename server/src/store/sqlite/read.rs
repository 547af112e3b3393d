//! What is kept, read back.

use super::document::{self, Unreadable};
use super::open::call_failed;
use crate::store::{
    Contents, Generation, StoreError, StoredEnvironment, StoredEvolution, StoredPrior, StoredRobot,
};
use rusqlite::{Connection, OptionalExtension, Row, params};
use std::path::Path;
use umwelt_core::controller::{STATE_VERSION, Saved};

/// Why something cannot be read.
#[derive(Debug)]
pub(super) enum ReadError {
    /// SQLite says no.
    Sqlite(rusqlite::Error),
    /// A row means nothing.
    Row { what: String, why: String },
}

impl From<rusqlite::Error> for ReadError {
    fn from(error: rusqlite::Error) -> Self {
        Self::Sqlite(error)
    }
}

impl ReadError {
    fn row(kind: &str, name: &str, why: &Unreadable) -> Self {
        Self::Row { what: format!("{kind} {name}"), why: why.to_string() }
    }

    pub(super) fn in_file(&self, file: &Path) -> StoreError {
        match self {
            Self::Sqlite(error) => call_failed(file, error),
            Self::Row { what, why } => {
                StoreError::Damaged(format!("{what} in {}: {why}", file.display()))
            }
        }
    }
}

/// Everything but generations and checkpoints, as of one moment.
pub(super) fn contents(connection: &mut Connection) -> Result<Contents, ReadError> {
    let moment = connection.transaction()?;
    let last = "SELECT value FROM numbers WHERE name = 'last_evolution'";
    Ok(Contents {
        robots: robots(&moment)?,
        priors: priors(&moment)?,
        environments: rows(&moment, "SELECT name, body FROM environments ORDER BY name", |row| {
            Ok(StoredEnvironment { name: row.get(0)?, body: row.get(1)? })
        })?,
        evolutions: rows(
            &moment,
            "SELECT id, number, finished, body FROM evolutions ORDER BY number",
            |row| {
                let number: i64 = row.get(1)?;
                Ok(StoredEvolution {
                    id: row.get(0)?,
                    number: number.unsigned_abs(),
                    finished: row.get(2)?,
                    body: row.get(3)?,
                })
            },
        )?,
        last_evolution: moment.query_row(last, [], |row| row.get::<_, i64>(0))?.unsigned_abs(),
    })
}

fn robots(connection: &Connection) -> Result<Vec<StoredRobot>, ReadError> {
    let all = "SELECT id, revision, robots.body, version, posteriors.body FROM robots \
               LEFT JOIN posteriors ON robot = id ORDER BY id";
    let found = rows(connection, all, |row| {
        let revision: i64 = row.get(1)?;
        let learned: Option<(u32, String)> = row.get::<_, Option<u32>>(3)?.zip(row.get(4)?);
        Ok((row.get::<_, String>(0)?, revision, row.get::<_, String>(2)?, learned))
    })?;
    let robot = |(name, revision, body, learned): (String, i64, String, Option<_>)| {
        let id = name.parse().map_err(|_| ReadError::Row {
            what: format!("robot {name}"),
            why: "it is no id".to_owned(),
        })?;
        let record = document::record(&body, revision.unsigned_abs())
            .map_err(|why| ReadError::row("robot", &name, &why))?;
        Ok(StoredRobot { id, record, saved: learned.and_then(|learned| saved(&name, &learned)) })
    };
    found.into_iter().map(robot).collect()
}

/// What a robot has learned, where this program can take it up; otherwise the robot learns anew.
fn saved(robot: &str, (version, body): &(u32, String)) -> Option<Saved> {
    if *version != STATE_VERSION {
        tracing::warn!(
            robot,
            version,
            current = STATE_VERSION,
            "what it learned is of another version of this program: it learns anew"
        );
        return None;
    }
    match document::saved(body) {
        Ok(saved) => Some(saved),
        Err(error) => {
            tracing::warn!(robot, %error, "what it learned cannot be read: it learns anew");
            None
        }
    }
}

fn priors(connection: &Connection) -> Result<Vec<StoredPrior>, ReadError> {
    let found = rows(connection, "SELECT name, body FROM priors ORDER BY name", |row| {
        Ok((row.get::<_, String>(0)?, row.get::<_, String>(1)?))
    })?;
    let prior = |(name, body): (String, String)| {
        document::prior(name.clone(), &body).map_err(|why| ReadError::row("prior", &name, &why))
    };
    found.into_iter().map(prior).collect()
}

/// Generations of an evolution from index `from` on.
pub(super) fn generations(
    connection: &Connection,
    evolution: &str,
    from: usize,
    limit: usize,
) -> Result<Vec<Generation>, ReadError> {
    let mut select = connection.prepare_cached(
        "SELECT position, body FROM generations WHERE evolution = ?1 AND position >= ?2 \
         ORDER BY position LIMIT ?3",
    )?;
    let bound = |number: usize| i64::try_from(number).unwrap_or(i64::MAX);
    let found = select.query_map(params![evolution, bound(from), bound(limit)], |row| {
        let index: i64 = row.get(0)?;
        Ok(Generation { index: index.unsigned_abs() as usize, body: row.get(1)? })
    })?;
    Ok(found.collect::<Result<_, _>>()?)
}

/// The checkpoint of an evolution.
pub(super) fn checkpoint(
    connection: &Connection,
    evolution: &str,
) -> Result<Option<String>, ReadError> {
    let select = "SELECT body FROM checkpoints WHERE evolution = ?1";
    Ok(connection.query_row(select, [evolution], |row| row.get(0)).optional()?)
}

fn rows<T>(
    connection: &Connection,
    select: &str,
    read: impl FnMut(&Row<'_>) -> rusqlite::Result<T>,
) -> Result<Vec<T>, ReadError> {
    Ok(connection.prepare(select)?.query_map([], read)?.collect::<Result<_, _>>()?)
}
