//! What is kept, read back.

use super::document::{self, Unreadable};
use super::open::call_failed;
use crate::store::{
    Contents, JobId, JobKind, Part, StoreError, StoredEnvironment, StoredJob, StoredPrior,
    StoredRobot,
};
use rusqlite::{Connection, OptionalExtension, Row, params};
use std::collections::BTreeMap;
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

/// Everything but parts and checkpoints, as of one moment.
pub(super) fn contents(connection: &mut Connection) -> Result<Contents, ReadError> {
    let moment = connection.transaction()?;
    Ok(Contents {
        robots: robots(&moment)?,
        priors: priors(&moment)?,
        environments: rows(&moment, "SELECT name, body FROM environments ORDER BY name", |row| {
            Ok(StoredEnvironment { name: row.get(0)?, body: row.get(1)? })
        })?,
        jobs: jobs(&moment)?,
        last_numbers: last_numbers(&moment)?,
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

fn jobs(connection: &Connection) -> Result<Vec<StoredJob>, ReadError> {
    let mut jobs = Vec::new();
    for kind in JobKind::ALL {
        let mut select = connection
            .prepare("SELECT number, finished, body FROM jobs WHERE kind = ?1 ORDER BY number")?;
        let of_kind = select.query_map([kind.name()], |row| {
            let number = row.get::<_, i64>(0)?.unsigned_abs();
            Ok(StoredJob { id: JobId { kind, number }, finished: row.get(1)?, body: row.get(2)? })
        })?;
        for job in of_kind {
            jobs.push(job?);
        }
    }
    Ok(jobs)
}

fn last_numbers(connection: &Connection) -> Result<BTreeMap<JobKind, u64>, ReadError> {
    let found = rows(connection, "SELECT kind, number FROM last_numbers", |row| {
        Ok((row.get::<_, String>(0)?, row.get::<_, i64>(1)?.unsigned_abs()))
    })?;
    Ok(found.into_iter().filter_map(|(kind, last)| Some((JobKind::named(&kind)?, last))).collect())
}

/// Parts of a job from index `from` on.
pub(super) fn parts(
    connection: &Connection,
    JobId { kind, number }: JobId,
    from: usize,
    limit: usize,
) -> Result<Vec<Part>, ReadError> {
    let mut select = connection.prepare_cached(
        "SELECT position, body FROM parts WHERE kind = ?1 AND number = ?2 AND position >= ?3 \
         ORDER BY position LIMIT ?4",
    )?;
    let (from, limit) = (bound(from as u64), bound(limit as u64));
    let found = select.query_map(params![kind.name(), bound(number), from, limit], |row| {
        let index: i64 = row.get(0)?;
        Ok(Part { index: index.unsigned_abs() as usize, body: row.get(1)? })
    })?;
    Ok(found.collect::<Result<_, _>>()?)
}

/// The checkpoint of a job.
pub(super) fn checkpoint(
    connection: &Connection,
    JobId { kind, number }: JobId,
) -> Result<Option<String>, ReadError> {
    let select = "SELECT body FROM checkpoints WHERE kind = ?1 AND number = ?2";
    let found = connection.query_row(select, params![kind.name(), bound(number)], |row| row.get(0));
    Ok(found.optional()?)
}

/// SQLite's integers have a sign; nothing that is kept has a larger number.
fn bound(number: u64) -> i64 {
    i64::try_from(number).unwrap_or(i64::MAX)
}

fn rows<T>(
    connection: &Connection,
    select: &str,
    read: impl FnMut(&Row<'_>) -> rusqlite::Result<T>,
) -> Result<Vec<T>, ReadError> {
    Ok(connection.prepare(select)?.query_map([], read)?.collect::<Result<_, _>>()?)
}
