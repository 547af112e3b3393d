//! How fast a job goes.

/// How fast a job goes, whatever its kind.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pace {
    /// Episodes driven, those of the batch that is going on included.
    pub episodes: u64,
    /// Episodes in all.
    pub total_episodes: u64,
    /// Time in s for which it has run.
    pub elapsed_s: f64,
    /// Time in s that it will still need; none where that is not known.
    pub remaining_s: Option<f64>,
}
