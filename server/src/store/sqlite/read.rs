//! What is kept, read back: every row is held against its checksum.

use super::damage::{self, Damage};
use super::open::call_failed;
use super::tables::{
    CHECKPOINTS, ENVIRONMENTS, JOBS, LAST_NUMBERS, PARTS, POSTERIORS, PRIORS, ROBOTS, Table,
};
use crate::store::document::{prior, robot};
use crate::store::{
    Contents, JobId, Kind, Part, StoreError, StoredEnvironment, StoredJob, StoredKind, StoredPrior,
    StoredRobot, Unreadable,
};
use rusqlite::{Connection, Params, Row, params};
use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;
use umwelt_core::controller::{STATE_VERSION, Saved};

/// Why something cannot be read.
#[derive(Debug)]
pub(super) enum ReadError {
    /// SQLite says no.
    Sqlite(rusqlite::Error),
    /// Rows are not what was written, or mean nothing.
    Damaged(Vec<Damage>),
}

impl From<rusqlite::Error> for ReadError {
    fn from(error: rusqlite::Error) -> Self {
        Self::Sqlite(error)
    }
}

impl ReadError {
    pub(super) fn in_file(&self, file: &Path) -> StoreError {
        match self {
            Self::Sqlite(error) => call_failed(file, error),
            Self::Damaged(damaged) => StoreError::Damaged(damage::message(file, damaged)),
        }
    }
}

/// Rows of one table.
struct Rows<T> {
    whole: Vec<T>,
    damaged: Vec<Damage>,
}

impl<T> Rows<T> {
    /// Reads rows of `table`: all, or those that `condition` says.
    fn read(
        connection: &Connection,
        table: &Table,
        condition: &str,
        values: impl Params,
        mut read: impl FnMut(&Row<'_>) -> Result<T, Box<dyn Error>>,
    ) -> rusqlite::Result<Self> {
        let mut select = connection.prepare_cached(&table.select(condition))?;
        let mut found = select.query(values)?;
        let (mut whole, mut damaged) = (Vec::new(), Vec::new());
        while let Some(row) = found.next()? {
            // First of all whether it is what was written: what a changed row says does not matter.
            if let Some(damage) = Damage::changed(table, row) {
                damaged.push(damage);
                continue;
            }
            match read(row) {
                Ok(one) => whole.push(one),
                Err(why) => damaged.push(Damage::of(table, row, why)),
            }
        }
        Ok(Self { whole, damaged })
    }

    /// Those that are whole; the others are said to `damaged`.
    fn or_say(self, damaged: &mut Vec<Damage>) -> Vec<T> {
        damaged.extend(self.damaged);
        self.whole
    }

    /// All of them, or an error.
    fn all(self) -> Result<Vec<T>, ReadError> {
        if self.damaged.is_empty() { Ok(self.whole) } else { Err(ReadError::Damaged(self.damaged)) }
    }
}

/// Everything but parts and checkpoints, as of one moment.
pub(super) fn contents(connection: &mut Connection) -> Result<Contents, ReadError> {
    let moment = connection.transaction()?;
    let mut damaged = Vec::new();
    let jobs = jobs(&moment)?.or_say(&mut damaged);
    let mut last_numbers: BTreeMap<_, _> =
        last_numbers(&moment)?.or_say(&mut damaged).into_iter().flatten().collect();
    for StoredJob { id: JobId { kind, number }, .. } in &jobs {
        // Where its row was taken out as damaged, no number of a job that is there comes again.
        let last = last_numbers.entry(*kind).or_default();
        *last = (*last).max(*number);
    }
    let mut unreadable = Vec::new();
    let contents = Contents {
        robots: robots(&moment, &mut damaged, &mut unreadable)?,
        priors: readable(priors(&moment)?.or_say(&mut damaged), &mut unreadable),
        environments: environments(&moment)?.or_say(&mut damaged),
        jobs,
        unreadable,
        last_numbers,
    };
    if damaged.is_empty() { Ok(contents) } else { Err(ReadError::Damaged(damaged)) }
}

/// Those that can be read; the others are noted.
fn readable<T>(rows: Vec<Result<T, Unreadable>>, unreadable: &mut Vec<Unreadable>) -> Vec<T> {
    let note = |row: Result<T, Unreadable>| row.map_err(|why| unreadable.push(why)).ok();
    rows.into_iter().filter_map(note).collect()
}

fn robots(
    connection: &Connection,
    damaged: &mut Vec<Damage>,
    unreadable: &mut Vec<Unreadable>,
) -> rusqlite::Result<Vec<StoredRobot>> {
    let found = Rows::read(connection, &ROBOTS, "ORDER BY id", [], |row| {
        let (name, revision): (String, i64) = (row.get(0)?, row.get(1)?);
        let (id, revision) = (name.parse()?, revision.unsigned_abs());
        let record = robot::record(&row.get::<_, String>(2)?, revision);
        Ok(match record {
            Ok(record) => Ok(StoredRobot { id, record, saved: None }),
            Err(why) => Err(Unreadable { revision, ..Unreadable::new(Kind::Robot, name, &why) }),
        })
    })?;
    let mut robots = readable(found.or_say(damaged), unreadable);
    let learned = Rows::read(connection, &POSTERIORS, "", [], |row| {
        let (robot, version): (String, u32) = (row.get(0)?, row.get(1)?);
        let saved = saved(&robot, version, &row.get::<_, String>(2)?)?;
        Ok((robot, saved))
    })?;
    let mut saved: BTreeMap<_, _> = learned.whole.into_iter().collect();
    for robot in &mut robots {
        robot.saved = saved.remove(robot.id.as_str()).flatten();
    }
    for damage in learned.damaged {
        let is_of = |name: &str| name == damage.key;
        match robots.iter_mut().find(|robot| is_of(robot.id.as_str())) {
            Some(robot) => learn_anew(robot, &damage),
            None if unreadable.iter().any(|it| it.kind == Kind::Robot && is_of(&it.name)) => {}
            // Whose it is cannot be told: that robot would begin its task anew, and no one would be told.
            None => damaged.push(damage),
        }
    }
    Ok(robots)
}

/// What a robot has learned, where it is of this program's version; otherwise the robot learns anew.
fn saved(robot: &str, version: u32, body: &str) -> Result<Option<Saved>, serde_json::Error> {
    if version == STATE_VERSION {
        return robot::saved(body).map(Some);
    }
    tracing::warn!(
        robot,
        version,
        current = STATE_VERSION,
        "robot learns anew: what it learned is of another version of this program"
    );
    Ok(None)
}

/// A robot whose knowledge is damaged: it can be learned again. With it is lost how far the robot's task had got, which
/// would begin anew; so the robot rests until someone resumes it.
fn learn_anew(robot: &mut StoredRobot, damage: &Damage) {
    robot.record.stopped = true;
    let remedy = "it is stopped: resume it, and it learns anew and begins its task anew";
    tracing::error!(robot = %robot.id, %damage, remedy, "cannot read what a robot has learned: damaged");
}

fn priors(connection: &Connection) -> rusqlite::Result<Rows<Result<StoredPrior, Unreadable>>> {
    Rows::read(connection, &PRIORS, "ORDER BY name", [], |row| {
        let name: String = row.get(0)?;
        let read = prior::prior(name.clone(), &row.get::<_, String>(1)?);
        Ok(read.map_err(|why| Unreadable::new(Kind::Prior, name, &why)))
    })
}

fn environments(connection: &Connection) -> rusqlite::Result<Rows<StoredEnvironment>> {
    Rows::read(connection, &ENVIRONMENTS, "ORDER BY name", [], |row| {
        Ok(StoredEnvironment { name: row.get(0)?, body: row.get(1)? })
    })
}

fn jobs(connection: &Connection) -> rusqlite::Result<Rows<StoredJob>> {
    let found = Rows::read(connection, &JOBS, "ORDER BY kind, number", [], |row| {
        let number = row.get::<_, i64>(1)?.unsigned_abs();
        // One of a kind that this program does not know stays where it is.
        let Some(kind) = StoredKind::named(&row.get::<_, String>(0)?) else { return Ok(None) };
        let (finished, body) = (row.get(2)?, row.get(3)?);
        Ok(Some(StoredJob { id: JobId { kind, number }, finished, body }))
    })?;
    let mut whole: Vec<_> = found.whole.into_iter().flatten().collect();
    // A kind has its place in the order of ids, and so has a number.
    whole.sort_by_key(|job| job.id);
    Ok(Rows { whole, damaged: found.damaged })
}

fn last_numbers(connection: &Connection) -> rusqlite::Result<Rows<Option<(StoredKind, u64)>>> {
    Rows::read(connection, &LAST_NUMBERS, "ORDER BY kind", [], |row| {
        let last = row.get::<_, i64>(1)?.unsigned_abs();
        Ok(StoredKind::named(&row.get::<_, String>(0)?).map(|kind| (kind, last)))
    })
}

/// Parts of a job from index `from` on.
pub(super) fn parts(
    connection: &Connection,
    JobId { kind, number }: JobId,
    from: usize,
    limit: usize,
) -> Result<Vec<Part>, ReadError> {
    let those = "WHERE kind = ?1 AND number = ?2 AND position >= ?3 ORDER BY position LIMIT ?4";
    let (from, limit) = (bound(from as u64), bound(limit as u64));
    let values = params![kind.name(), bound(number), from, limit];
    Rows::read(connection, &PARTS, those, values, |row| {
        let index: i64 = row.get(2)?;
        Ok(Part { index: index.unsigned_abs() as usize, body: row.get(3)? })
    })?
    .all()
}

/// The checkpoint of a job.
pub(super) fn checkpoint(
    connection: &Connection,
    JobId { kind, number }: JobId,
) -> Result<Option<String>, ReadError> {
    let that = "WHERE kind = ?1 AND number = ?2";
    let values = params![kind.name(), bound(number)];
    let found = Rows::read(connection, &CHECKPOINTS, that, values, |row| Ok(row.get(2)?))?;
    Ok(found.all()?.pop())
}

/// SQLite's integers have a sign; nothing that is kept has a larger number.
fn bound(number: u64) -> i64 {
    i64::try_from(number).unwrap_or(i64::MAX)
}
