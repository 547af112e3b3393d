//! The tables as those see them who go through all of them: what is a row's key, and whether a row is whole.

/// A table, of which every column but `checksum` is named here.
#[derive(Debug)]
pub(super) struct Table {
    pub(super) name: &'static str,
    pub(super) key: &'static [&'static str],
    /// What is not the key, in the order in which the checksum takes it in.
    rest: &'static [&'static str],
}

pub(super) const NUMBERS: Table = Table { name: "numbers", key: &["name"], rest: &["value"] };
pub(super) const ROBOTS: Table =
    Table { name: "robots", key: &["id"], rest: &["revision", "body"] };
pub(super) const POSTERIORS: Table =
    Table { name: "posteriors", key: &["robot"], rest: &["version", "body"] };
pub(super) const PRIORS: Table = Table { name: "priors", key: &["name"], rest: &["body"] };
pub(super) const ENVIRONMENTS: Table =
    Table { name: "environments", key: &["name"], rest: &["body"] };
pub(super) const JOBS: Table =
    Table { name: "jobs", key: &["kind", "number"], rest: &["finished", "body"] };
pub(super) const PARTS: Table =
    Table { name: "parts", key: &["kind", "number", "position"], rest: &["body"] };
pub(super) const CHECKPOINTS: Table =
    Table { name: "checkpoints", key: &["kind", "number"], rest: &["body"] };
pub(super) const LAST_NUMBERS: Table =
    Table { name: "last_numbers", key: &["kind"], rest: &["number"] };

/// Every table there is.
pub(super) const ALL: [&Table; 9] = [
    &ROBOTS,
    &POSTERIORS,
    &PRIORS,
    &ENVIRONMENTS,
    &JOBS,
    &PARTS,
    &CHECKPOINTS,
    &LAST_NUMBERS,
    &NUMBERS,
];

impl Table {
    /// How many columns there are but the checksum.
    pub(super) fn width(&self) -> usize {
        self.key.len() + self.rest.len()
    }

    /// Its columns but the checksum, for SQL: those of the key first.
    pub(super) fn columns(&self) -> String {
        [self.key, self.rest].concat().join(", ")
    }

    /// Whether a row is as it was written, for SQL.
    pub(super) fn is_whole(&self) -> String {
        format!("(checksum IS row_checksum('{}', {}))", self.name, self.columns())
    }

    /// All columns but the checksum, then whether the row is whole.
    pub(super) fn select(&self, rest: &str) -> String {
        format!("SELECT {}, {} FROM {} {rest}", self.columns(), self.is_whole(), self.name)
    }
}
