//! Files that the process may have open: a connection is one.

use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

/// What is open beside connections: the store with its log and locks, the runtime, standard streams, and some to spare.
const OTHERS: u64 = 128;

/// Lets the process open files for so many connections, as far as the system does.
pub(crate) fn allow_files(connections: usize) {
    let needed = u64::try_from(connections).unwrap_or(u64::MAX).saturating_add(OTHERS);
    let limit = getrlimit(Resource::Nofile);
    let allowed = raised(limit, needed);
    if limit.current != allowed.current
        && let Err(error) = setrlimit(Resource::Nofile, allowed)
    {
        tracing::warn!(%error, "the limit of open files cannot be raised");
    }
    let current = getrlimit(Resource::Nofile).current;
    if let Some(current) = current.filter(|current| *current < needed) {
        tracing::warn!(
            current,
            needed,
            "the system allows fewer open files than --max-connections needs: connections beyond them wait; \
             raise it (ulimit -n, LimitNOFILE) or lower --max-connections"
        );
    }
}

/// The limit with its lower part at `needed`, or as near as its upper part lets it come; never lower than it was.
fn raised(limit: Rlimit, needed: u64) -> Rlimit {
    // None is no limit.
    let most = limit.maximum.map_or(needed, |maximum| needed.min(maximum));
    Rlimit { current: limit.current.map(|current| current.max(most)), ..limit }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_raised_as_far_as_is_needed_and_allowed_and_never_lowered() {
        let raised = |current, maximum, needed| {
            let Rlimit { current, .. } = raised(Rlimit { current, maximum }, needed);
            current
        };
        assert_eq!(raised(Some(1024), Some(1_048_576), 4352), Some(4352));
        assert_eq!(raised(Some(1024), Some(4096), 4352), Some(4096));
        assert_eq!(raised(Some(1024), None, 4352), Some(4352));
        assert_eq!(raised(Some(10_000), Some(20_000), 4352), Some(10_000));
        assert_eq!(raised(None, None, 4352), None);
    }
}
