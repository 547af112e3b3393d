//! Faults injected into everything at once: a server and agents as processes, links, trackers, wheels, the disk, and
//! operators who stop, resume and change things all the while.
//!
//! * `schedule`: which fault comes to whom and when, by a seed; `inject`: how each is injected and lifted.
//! * `life`: the server; `robot` and `body`: a robot, its agent and what it truly is and does.
//! * `judge`: what a robot must not do; `facts`: what was acknowledged and must stay.
//! * `field`: all of them, and the operator; `report`: what came of it.
//!
//! Judged is how the robots truly move, by one monotonic clock in this process. Where this process itself stood still
//! nothing is judged.

mod body;
mod facts;
mod field;
mod inject;
mod judge;
mod life;
mod report;
mod robot;
mod schedule;

pub use report::Report;
pub use schedule::{Kind, schedule};

use facts::{Facts, Kept};
use field::Field;
use inject::lane;
use judge::Counts;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use tokio::sync::oneshot;
use tokio::time::Instant;

/// Time between two looks at the robots' motion: a third of a slot.
const TICK: Duration = Duration::from_millis(10);

/// A time between two ticks in s after which the harness itself stood still.
const STALL: f64 = 0.3;

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// How many robots drive.
    pub robots: usize,
    /// How many faults are injected.
    pub injections: usize,
    /// Seed of everything that is random.
    pub seed: u64,
    /// Whether nothing is said on standard error meanwhile.
    pub is_quiet: bool,
}

/// Drives the robots and injects the faults. Needs tokio's runtime of several threads.
///
/// # Panics
/// Where a server or an agent does not start.
pub async fn run(plan: Plan) -> Report {
    let Plan { robots, injections, seed, is_quiet } = plan;
    let field = Arc::new(Field::prepare(robots, seed, is_quiet).await);
    let end = Arc::new(AtomicBool::new(false));
    let world = {
        let (field, end) = (Arc::clone(&field), Arc::clone(&end));
        std::thread::spawn(move || turn(&field, &end))
    };
    let (no_more, ends) = oneshot::channel::<()>();
    let changing = {
        let field = Arc::clone(&field);
        let facts = Facts::new(field.life.address, seed);
        facts.prepare().await;
        tokio::spawn(async move {
            let ends = async {
                // Told, or no one is there any more to tell.
                let _ = ends.await;
            };
            facts.run(ends, &field.stops_of_all).await
        })
    };
    let looking_after = {
        let field = Arc::clone(&field);
        tokio::spawn(async move { field.look_after().await })
    };

    let began = Instant::now();
    let all = schedule(seed, injections, robots);
    let mut lanes = Vec::new();
    for whose in std::iter::once(None).chain((0..robots).map(Some)) {
        let mine = all.iter().filter(|it| it.robot == whose).cloned().collect();
        let field = Arc::clone(&field);
        lanes.push(tokio::spawn(async move { lane(&field, began, mine).await }));
    }
    for lane in lanes {
        lane.await.expect("a lane does not panic");
    }
    let wall_time = began.elapsed().as_secs_f64();
    // Who was asked to end has.
    let _ = no_more.send(());
    let kept = changing.await.expect("facts do not panic");
    looking_after.abort();
    let _ = looking_after.await;
    end.store(true, Ordering::SeqCst);
    world.join().expect("the world does not panic");
    finish(plan, wall_time, field, kept)
}

fn finish(plan: Plan, wall_time: f64, field: Arc<Field>, kept: Kept) -> Report {
    let mut counts = Counts::default();
    for robot in &field.robots {
        counts.add(robot.body.judge(|judge, _| judge.counts()));
    }
    let field = Arc::into_inner(field).expect("nobody else has it any more");
    Report::new(plan.seed, plan.robots, wall_time, field.into_tally(), (kept, counts))
}

/// Moves all robots until `end`, and notices where it could not.
fn turn(field: &Field, end: &AtomicBool) {
    let mut last = field.clock.now();
    while !end.load(Ordering::SeqCst) {
        std::thread::sleep(TICK);
        let now = field.clock.now();
        let gap = now - last;
        last = now;
        if gap > STALL {
            field.count(|tally| {
                tally.stalls += 1;
                tally.longest_stall = tally.longest_stall.max(gap);
            });
            for robot in &field.robots {
                robot.body.judge(|judge, now| judge.stood_still(now));
            }
        }
        for robot in &field.robots {
            robot.body.tick();
        }
    }
}
