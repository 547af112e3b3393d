//! Whatever valid requests come in whatever order: a controller answers each of them soon, and within its limits.
//!
//! Robots, tasks and requests are drawn over the whole of the contract's ranges and read as the wire reads them, so none
//! of them is one that the server would refuse. What has to hold of every answer is in [`judge`].

#![allow(clippy::unwrap_used, reason = "in a test a panic is the report")]

mod draw;
mod drive;
mod judge;

use draw::{Act, Said, act, clock};
use proptest::prelude::*;
use proptest::test_runner::TestCaseResult;
use serde_json::json;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;
use umwelt_api::prior::built_in;
use umwelt_api::robot::Description;
use umwelt_api::task;

/// Robots that are driven: some seconds of them.
const ROBOTS: u32 = 200;

/// Most acts of one of them.
const ACTS: usize = 48;

/// Time for all answers of one robot; they take milliseconds, and a machine may be a thousand times busier than ours.
const BOUND: Duration = Duration::from_secs(20);

proptest! {
    #![proptest_config(ProptestConfig {
        cases: ROBOTS,
        failure_persistence: None,
        max_shrink_iters: 2000,
        ..ProptestConfig::default()
    })]

    /// Guards against: a clock or a pause of some size computes for ever, a pose far away makes a belief infinite, a
    /// command is out of the drive's limits, a stopped robot is told to drive.
    #[test]
    fn every_valid_request_is_answered_soon_and_within_all_limits(
        robot in draw::robot(),
        first in draw::task(),
        began in clock(),
        acts in prop::collection::vec(act(), 1..ACTS),
    ) {
        in_bounded_time(move || drive::drive(&robot, first, began, acts))?;
    }
}

/// Guards against: agents of a Monte Carlo that believes nothing yet are drawn infinitely far away, and the robot turns
/// toward a place that is no number, at full speed.
#[test]
fn a_robot_that_cannot_tell_where_it_will_be_stays_within_its_limits() {
    let task = task::Spec::read(br#"{"waypoints": [{"x_m": -0.4, "y_m": 0.1}], "reverse": true}"#);
    let task = task.unwrap().to_core(0.01);
    for seed in 0..200 {
        let spec = json!({
            "prior": "flat",
            "predictor": {"kind": "monte-carlo", "agents": 2, "cell_m": 1.0, "seed": seed},
        });
        let read = Description::read_known(spec.to_string().as_bytes(), built_in);
        let (_, robot) = read.unwrap();
        let acts = vec![Act::Steps(vec![Said::regular(); 60])];
        drive::drive(&robot, task.clone(), 0.0, acts).unwrap();
    }
}

/// The result of `run`, which fails where it computes for too long: what hangs must fail, and not hang the test.
fn in_bounded_time(run: impl FnOnce() -> TestCaseResult + Send + 'static) -> TestCaseResult {
    /// After one that hangs no other is tried, or the test would look for a smaller one for ever.
    static HANGS: AtomicBool = AtomicBool::new(false);
    if HANGS.load(Ordering::Relaxed) {
        return Ok(());
    }
    let (sender, result) = mpsc::channel();
    // The thread of one that hangs ends with the test's process.
    std::thread::spawn(move || sender.send(run()));
    match result.recv_timeout(BOUND) {
        Ok(result) => result,
        Err(RecvTimeoutError::Timeout) => {
            HANGS.store(true, Ordering::Relaxed);
            Err(TestCaseError::fail(format!("not answered within {BOUND:?}")))
        }
        Err(RecvTimeoutError::Disconnected) => Err(TestCaseError::fail("the controller panicked")),
    }
}
