//! What names a job: its kind and its number.

use std::fmt;

/// What the server does in the background.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum StoredKind {
    /// A prior is searched for.
    Evolution,
    /// Methods are compared.
    Comparison,
    /// Numbers are counted: the kind with which tests show what all kinds share.
    #[cfg(test)]
    Counting,
}

impl StoredKind {
    /// Every kind.
    pub const ALL: [Self; 2] = [Self::Evolution, Self::Comparison];

    /// Its name, in ids and on the disk.
    pub fn name(self) -> &'static str {
        match self {
            Self::Evolution => "evolution",
            Self::Comparison => "comparison",
            #[cfg(test)]
            Self::Counting => "counting",
        }
    }

    /// The kind of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }
}

impl fmt::Display for StoredKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Which job: shown as `evolution-12`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct JobId {
    /// What it does.
    pub kind: StoredKind,
    /// Its number: greater than that of every job of its kind before it, and never used again.
    pub number: u64,
}

impl fmt::Display for JobId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}-{}", self.kind, self.number)
    }
}
