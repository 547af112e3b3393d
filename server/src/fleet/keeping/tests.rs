//! A model of what was said about each robot, against the fleet with its journal and a store that stalls, fails and
//! dies, over arbitrary interleavings.

use super::*;
use crate::fleet::feed::Feed;
use crate::fleet::robot::{Common, Workers};
use crate::library::priors::Priors;
use crate::program::config::Config;
use crate::resource::condition::Condition;
use crate::store::Told;
use crate::store::{
    Contents, JobId, Keeper, MemoryStore, Part, StopKeeper, Store, StoreError, stop_journal,
};
use proptest::prelude::*;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex};
use tempfile::tempdir;
use tokio::runtime::Runtime;
use umwelt_api::RobotId;
use umwelt_core::settings::Settings;

const ROBOTS: usize = 3;

fn id(robot: usize) -> RobotId {
    format!("r{robot}").parse().unwrap()
}

/// The store as one run of the server sees it: it stalls and fails as it is told, and does nothing after a crash.
struct Disk {
    kept: Arc<MemoryStore>,
    stalls: Mutex<bool>,
    goes_on: Condvar,
    fails: AtomicBool,
    has_crashed: AtomicBool,
}

impl Disk {
    fn stall(&self, stalls: bool) {
        *self.stalls.lock().unwrap() = stalls;
        self.goes_on.notify_all();
    }
}

impl Store for Disk {
    fn commit(&self, changes: Vec<Change>) -> Result<(), StoreError> {
        let mut stalls = self.stalls.lock().unwrap();
        while *stalls {
            stalls = self.goes_on.wait(stalls).unwrap();
        }
        if self.fails.load(Ordering::SeqCst) || self.has_crashed.load(Ordering::SeqCst) {
            return Err(StoreError::Unavailable("as a test wants it".to_owned()));
        }
        self.kept.commit(changes)
    }

    fn load(&self) -> Result<Contents, StoreError> {
        self.kept.load()
    }

    fn parts(&self, _: JobId, _: usize, _: usize) -> Result<Vec<Part>, StoreError> {
        Ok(Vec::new())
    }

    fn checkpoint(&self, _: JobId) -> Result<Option<String>, StoreError> {
        Ok(None)
    }
}

/// One run of the server, from its start to a crash.
struct Life {
    runtime: Runtime,
    fleet: Fleet,
    disk: Arc<Disk>,
}

impl Life {
    fn begin(kept: &Arc<MemoryStore>, directory: &Path, with_journal: bool) -> Self {
        let runtime =
            tokio::runtime::Builder::new_current_thread().enable_all().start_paused(true).build();
        let runtime = runtime.unwrap();
        let disk = Arc::new(Disk {
            kept: Arc::clone(kept),
            stalls: Mutex::default(),
            goes_on: Condvar::new(),
            fails: AtomicBool::default(),
            has_crashed: AtomicBool::default(),
        });
        let fleet = runtime.block_on(async {
            let stops = if with_journal {
                let (journal, words) = stop_journal(directory).unwrap();
                Stops { journal: journal.map(|journal| StopKeeper::start(journal).unwrap()), words }
            } else {
                Stops::default()
            };
            let (feed, priors) = (Feed::new(), Priors::default());
            let workers = Workers::start().unwrap();
            let common = Common { lost_after: Duration::from_secs(2), feed, priors, workers };
            let robots = disk.load().unwrap().robots;
            let keeper = Keeper::new(disk.clone());
            let Config { max_robots, save_every, .. } = Config::default();
            Fleet::open(max_robots, save_every, keeper, common, robots, stops, Default::default())
        });
        Self { runtime, fleet, disk }
    }

    fn crash(self) {
        self.disk.has_crashed.store(true, Ordering::SeqCst);
        self.disk.stall(false);
        drop(self.fleet);
        self.runtime.shutdown_timeout(Duration::from_secs(10));
    }

    /// Lets what is under way get on for a while.
    fn run(&self, turns: u32) {
        self.runtime.block_on(async {
            for _ in 0..turns {
                tokio::task::yield_now().await;
            }
        });
    }

    fn is_stopped(&self, robot: usize) -> bool {
        self.fleet.find(&id(robot)).unwrap().is_stopped()
    }
}

/// What came of a request.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Outcome {
    /// Nothing yet.
    Open,
    Done,
    /// A stop that holds and is not kept.
    NotKept,
    Overtaken,
    Refused,
}

#[derive(Clone, Debug)]
struct Said {
    robots: Vec<usize>,
    of_all: bool,
    stop: bool,
    outcome: Outcome,
    /// How many requests had arrived when the answer came.
    answered: usize,
}

type History = Arc<Mutex<Vec<Said>>>;

/// Sends a request; it takes its place in `history` when it arrives.
fn send(life: &Life, history: &History, robot: Option<usize>, stop: bool) {
    let (fleet, history) = (life.fleet.clone(), Arc::clone(history));
    life.runtime.spawn(async move {
        let robots = robot.map_or_else(|| (0..ROBOTS).collect(), |robot| vec![robot]);
        let place = {
            let mut history = history.lock().unwrap();
            let of_all = robot.is_none();
            let (outcome, answered) = (Outcome::Open, usize::MAX);
            history.push(Said { robots, of_all, stop, outcome, answered });
            history.len() - 1
        };
        let found = robot.map(|robot| fleet.find(&id(robot)).unwrap());
        let result = match (found, stop) {
            (Some(robot), true) => fleet.stop(robot).await,
            (Some(robot), false) => fleet.resume(robot).await.map(|()| true),
            (None, true) => fleet.stop_all().await.map(|(_, kept)| kept),
            (None, false) => fleet.resume_all().await.map(|_| true),
        };
        let outcome = match result {
            Ok(true) => Outcome::Done,
            Ok(false) => Outcome::NotKept,
            Err(failure) if format!("{failure:?}").contains(reason::OVERTAKEN) => {
                Outcome::Overtaken
            }
            Err(_) => Outcome::Refused,
        };
        let mut history = history.lock().unwrap();
        history[place].answered = history.len();
        history[place].outcome = outcome;
    });
}

/// Whether a robot that began stopped or not, as `begin` says, may be `stopped` now, or after a crash.
///
/// A stop has its place between its arrival and its answer, a resume where it arrives. So a robot may rest where there is a
/// stop behind whose answer no resume arrived that was acknowledged; and it may go on where there is a resume, acknowledged
/// or still open, behind which no stop arrived; after a crash none that was kept.
fn may_be(stopped: bool, begin: bool, history: &[Said], robot: usize, after_crash: bool) -> bool {
    let of_robot = || history.iter().enumerate().filter(|(_, said)| said.robots.contains(&robot));
    let stops = || of_robot().filter(|(_, said)| said.stop);
    let resumes = || of_robot().filter(|(_, said)| !said.stop);
    let is_done = |said: &Said| said.outcome == Outcome::Done;
    if stopped {
        let holds = |answered: usize| !resumes().any(|(at, said)| is_done(said) && at >= answered);
        return (begin && holds(0)) || stops().any(|(_, said)| holds(said.answered));
    }
    let counts = |said: &Said| !after_crash || is_done(said);
    let holds = |from: usize| !stops().any(|(at, said)| counts(said) && at >= from);
    let goes_on = |said: &Said| match said.outcome {
        Outcome::Done | Outcome::Open => true,
        // Of all robots those that no stop has overtaken go on. A resume that a stop has overtaken may have been kept: where
        // the stop was not, and said so, a crash lets the robot go on.
        Outcome::Overtaken => said.of_all || after_crash,
        _ => false,
    };
    (!begin && holds(0)) || resumes().any(|(at, said)| goes_on(said) && holds(at))
}

#[derive(Clone, Debug)]
enum Op {
    Say {
        robot: Option<usize>,
        stop: bool,
    },
    Run(u32),
    /// Real time for calls of the store, and virtual time for the one who brings words there.
    Wait,
    Stall(bool),
    Fail(bool),
    Recreate(usize),
    Crash,
}

fn op() -> impl Strategy<Value = Op> {
    let say = (prop::option::weighted(0.7, 0..ROBOTS), any::<bool>());
    prop_oneof![
        8 => say.prop_map(|(robot, stop)| Op::Say { robot, stop }),
        4 => (0u32..6).prop_map(Op::Run),
        2 => Just(Op::Wait),
        1 => any::<bool>().prop_map(Op::Stall),
        1 => any::<bool>().prop_map(Op::Fail),
        1 => (0..ROBOTS).prop_map(Op::Recreate),
        1 => Just(Op::Crash),
    ]
}

/// Plays `ops` and holds the fleet to what was said.
fn play(ops: Vec<Op>, with_journal: bool) {
    let (kept, directory) = (Arc::new(MemoryStore::default()), tempdir().unwrap());
    let mut life = Life::begin(&kept, directory.path(), with_journal);
    life.runtime.block_on(async {
        for robot in 0..ROBOTS {
            let put =
                life.fleet.put(id(robot), Told::all(Settings::default()), Condition::default());
            put.await.unwrap();
        }
    });
    let mut begins = [false; ROBOTS];
    let mut history = History::default();
    for op in ops.into_iter().chain([Op::Crash, Op::Crash]) {
        match op {
            Op::Say { robot, stop } => send(&life, &history, robot, stop),
            Op::Run(turns) => life.run(turns),
            Op::Wait => {
                // Stops settle first, then the store is asked again.
                for part in 0..20 {
                    if part % 10 == 0 {
                        life.runtime.block_on(tokio::time::advance(RETRY));
                    }
                    life.run(3);
                    std::thread::sleep(Duration::from_micros(100));
                }
            }
            Op::Stall(stalls) => life.disk.stall(stalls),
            Op::Fail(fails) => life.disk.fails.store(fails, Ordering::SeqCst),
            Op::Recreate(robot) => {
                life.run(3);
                let is_open = |said: &Said| said.outcome == Outcome::Open;
                if history.lock().unwrap().iter().any(is_open) || *life.disk.stalls.lock().unwrap()
                {
                    continue;
                }
                let (fleet, found) = (&life.fleet, life.fleet.find(&id(robot)).unwrap());
                let is_anew = life.runtime.block_on(async {
                    if fleet.delete(found, Condition::default()).await.is_err() {
                        return false;
                    }
                    let put =
                        fleet.put(id(robot), Told::all(Settings::default()), Condition::default());
                    put.await.unwrap();
                    true
                });
                if is_anew {
                    begins[robot] = false;
                    for said in history.lock().unwrap().iter_mut() {
                        said.robots.retain(|of| *of != robot);
                    }
                }
            }
            Op::Crash => {
                let before = history.lock().unwrap().clone();
                life.crash();
                history = History::default();
                life = Life::begin(&kept, directory.path(), with_journal);
                for (robot, begin) in begins.iter_mut().enumerate() {
                    let now = life.is_stopped(robot);
                    let may_be = may_be(now, *begin, &before, robot, true);
                    assert!(may_be, "{robot} after a crash: {now}, {before:?}");
                    *begin = now;
                }
            }
        }
        let said = history.lock().unwrap().clone();
        for (robot, begin) in begins.iter().enumerate() {
            let now = life.is_stopped(robot);
            assert!(may_be(now, *begin, &said, robot, false), "{robot}: {now}, {said:?}");
        }
    }
    life.crash();
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, ..ProptestConfig::default() })]

    /// Guards against: a resume that undoes a later stop, in the robot, in the journal or in the store; a word that is
    /// acknowledged and gone after a crash; one that comes back from the journal after another took its place.
    #[test]
    fn the_last_acknowledged_word_holds_whatever_happens(
        ops in prop::collection::vec(op(), 1..40), with_journal in prop::bool::weighted(0.7),
    ) {
        play(ops, with_journal);
    }
}
