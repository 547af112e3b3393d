//! All kinds of faults at once, and what must hold all the same.

use umwelt_tests::faults::{self, Kind, Plan};

/// Few robots and a round of all kinds, then some again: a minute and a bit.
const PLAN: Plan = Plan { robots: 6, injections: 22, seed: 1, is_quiet: true };

/// Guards against: what was acknowledged is gone, a stopped robot moves, one drives blind, a limit is broken, or
/// something never goes on. `cargo run --release -p umwelt-tests --example faults` does the same for longer.
#[tokio::test(flavor = "multi_thread")]
async fn whatever_fails_nothing_is_lost_and_no_one_drives_who_must_not() {
    let report = faults::run(PLAN).await;
    println!("{report}");
    assert!(report.is_clean(), "{report}");
    for kind in Kind::ALL {
        assert!(report.injections.contains_key(&kind), "{kind:?} was not injected");
    }
    // Nothing is found where nothing is looked at.
    assert!(report.facts.checked > 50, "{report}");
    assert!(report.motion.stops >= 2 && report.motion.lines > 1000, "{report}");
}
