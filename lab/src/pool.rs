//! Drives the episodes of evolutions and comparisons on threads of their own.
//!
//! Invariants: evaluations are told in the order of the batch, so the number of threads never shows in a result; a
//! batch that is stopped or fails leaves its job as it was before it; whoever stops one waits for no more than the
//! episodes that are being driven; jobs that run at the same time share the threads evenly, and none waits for another
//! one's batch.

use crate::work::{Told, Work};
use rayon::prelude::*;
use std::any::Any;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Once;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use thread_priority::{
    NormalThreadSchedulePolicy, ThreadPriority, ThreadSchedulePolicy,
    set_thread_priority_and_policy, thread_native_id,
};

/// How threads stand beside the others of the system.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Priority {
    /// As all others.
    Normal,
    /// They run where nothing else wants to (`SCHED_IDLE`): a step preempts them at once.
    #[default]
    Lowest,
}

/// Episodes per thread that a job drives before another one has its turn: some tenths of a second, so that neither
/// waits long for the other, and the threads seldom wait for the slowest of them. A whole batch would not do: a thread
/// that waits for the last episodes of one job begins another job's, and ends that first.
const TURN: usize = 64;

/// Threads that drive episodes.
#[derive(Debug)]
pub struct Pool(rayon::ThreadPool);

/// How far a batch has got, and whether it is to go on: shared between who evaluates and who watches.
#[derive(Debug, Default)]
pub struct Meter {
    episodes: AtomicU64,
    stopped: AtomicBool,
}

impl Meter {
    /// Episodes that the job has driven, those of the batch that is going on included.
    pub fn episodes(&self) -> u64 {
        self.episodes.load(Ordering::Relaxed)
    }

    /// Ends the batch as soon as the episodes that are being driven have ended.
    pub fn stop(&self) {
        self.stopped.store(true, Ordering::Relaxed);
    }

    fn is_stopped(&self) -> bool {
        self.stopped.load(Ordering::Relaxed)
    }
}

/// Why a batch did not come to its end.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum Halt {
    /// Somebody stopped it; the job is as it was before the batch.
    #[error("it was stopped")]
    Stopped,
    /// An evaluation panicked.
    #[error("an evaluation failed: {0}")]
    Panicked(String),
    /// The evaluations were not those that the job had asked for.
    #[error("{0}")]
    Told(String),
}

impl Pool {
    /// So many threads, all cores where none are said.
    ///
    /// # Errors
    /// Where the system does not give the threads.
    pub fn new(threads: Option<usize>, priority: Priority) -> io::Result<Self> {
        let threads = rayon::ThreadPoolBuilder::new()
            .num_threads(threads.unwrap_or(0))
            .thread_name(|index| format!("episodes-{index}"))
            .start_handler(move |_| {
                if priority == Priority::Lowest {
                    lower();
                }
            })
            .build()
            .map_err(|error| io::Error::other(format!("no threads for episodes: {error}")))?;
        Ok(Self(threads))
    }

    /// Does `work` on a thread of the pool, and so at its priority. Blocks until it is done.
    pub fn install<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        self.0.install(work)
    }

    /// How many threads there are.
    pub fn threads(&self) -> usize {
        self.0.current_num_threads()
    }

    /// Drives what `work` asks for now and tells it. Blocks until that is done.
    ///
    /// # Errors
    /// Where it was stopped or failed; after a panic the work is not to be used any more.
    pub fn step<W: Work>(&self, work: &mut W, meter: &Meter) -> Result<Told<W>, Halt> {
        meter.episodes.store(work.episodes(), Ordering::Relaxed);
        guarded(|| {
            // All of it in the pool: making a batch and breeding take time too.
            let batch = self.install(|| work.batch());
            let mut evaluations = Vec::with_capacity(batch.len());
            for turn in batch.chunks(TURN * self.threads()) {
                evaluations.extend(self.install(|| drive(work, turn, meter))?);
            }
            self.install(|| work.tell(&evaluations)).map_err(Halt::Told)
        })?
    }
}

/// Drives some episodes.
fn drive<W: Work>(
    work: &W,
    episodes: &[W::Episode],
    meter: &Meter,
) -> Result<Vec<W::Evaluation>, Halt> {
    let evaluate = |episode: &W::Episode| {
        if meter.is_stopped() {
            return Err(Halt::Stopped);
        }
        // Caught here, a panic ends the batch at once; left to the pool it would drive the rest first.
        let evaluation = guarded(|| work.evaluate(episode))?;
        meter.episodes.fetch_add(1, Ordering::Relaxed);
        Ok(evaluation)
    };
    // An episode takes milliseconds: each is worth its own place in the queue.
    episodes.par_iter().with_max_len(1).map(evaluate).collect()
}

fn guarded<T>(call: impl FnOnce() -> T) -> Result<T, Halt> {
    // What a panic leaves half done is not used any more.
    catch_unwind(AssertUnwindSafe(call)).map_err(|panic| Halt::Panicked(said(&*panic)))
}

/// What a panic said.
fn said(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("nothing").to_owned()
}

/// Time in s that will still be needed at the pace so far; none where nothing has been done yet.
pub fn remaining(elapsed: f64, episodes: u64, total: u64) -> Option<f64> {
    (episodes > 0).then(|| elapsed / episodes as f64 * total.saturating_sub(episodes) as f64)
}

/// Puts the calling thread behind all others.
fn lower() {
    static WARNED: Once = Once::new();
    let policy = ThreadSchedulePolicy::Normal(NormalThreadSchedulePolicy::Idle);
    let lowered = set_thread_priority_and_policy(thread_native_id(), ThreadPriority::Min, policy);
    if let Err(error) = lowered {
        WARNED.call_once(|| {
            tracing::warn!(%error, "jobs run at normal priority and may delay the control of robots");
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fake_work::{Toy, Wishes};
    use std::sync::Arc;
    use std::sync::mpsc;
    use std::thread;

    fn toy(wishes: Wishes) -> Toy {
        Toy::new(wishes).unwrap()
    }

    fn pool(threads: usize) -> Pool {
        Pool::new(Some(threads), Priority::Normal).unwrap()
    }

    /// The bug to fear: evaluations told in the order in which they were done.
    #[test]
    fn the_number_of_threads_never_shows() {
        // More than one turn of any of them.
        let wishes = Wishes { batches: 3, episodes: 1000, ..Wishes::default() };
        let run = |threads| {
            let (pool, meter) = (pool(threads), Meter::default());
            let (mut toy, mut parts) = (toy(wishes), Vec::new());
            while toy.report().is_none() {
                parts.extend(pool.step(&mut toy, &meter).unwrap().parts);
                assert_eq!(meter.episodes(), toy.episodes());
            }
            (toy, parts)
        };
        let alone = run(1);
        assert_eq!(alone.1.len(), 3);
        assert_eq!(run(3), alone);
    }

    #[test]
    fn a_batch_that_is_stopped_leaves_its_job_as_it_was() {
        let (mut toy, meter) = (toy(Wishes::default()), Meter::default());
        let before = toy.clone();
        meter.stop();
        assert_eq!(pool(2).step(&mut toy, &meter), Err(Halt::Stopped));
        assert_eq!(toy, before);
        assert_eq!(meter.episodes(), 0);
    }

    /// The bug to fear: a panic that takes the process with it, or a batch that goes on for hours behind it.
    #[test]
    fn a_panic_ends_its_batch_and_nothing_else() {
        let wishes = Wishes { episodes: 1000, micros: 100, ..Wishes::default() };
        let (pool, meter) = (pool(2), Meter::default());
        let halt = pool.step(&mut toy(Wishes { panics: true, ..wishes }), &meter).unwrap_err();
        assert_eq!(halt.to_string(), "an evaluation failed: no floor under the robot");
        // Saying what happened takes longer than many episodes, but no other turn begins.
        assert!(meter.episodes() < 2 * TURN as u64, "{} were driven", meter.episodes());
        assert!(pool.step(&mut toy(wishes), &meter).is_ok());
    }

    /// The bug to fear: a job of seconds that waits for the batch of another one, which takes hours, be it in a queue
    /// or because a thread that waits for the one has begun the other.
    #[test]
    fn jobs_share_the_threads_and_none_waits_for_the_batch_of_another() {
        let pool = Arc::new(pool(2));
        // Ten seconds of both threads.
        const MANY: u64 = 200_000;
        let many = Wishes { episodes: MANY as usize, micros: 100, ..Wishes::default() };
        let meter = Arc::new(Meter::default());
        let long = thread::spawn({
            let (pool, meter) = (Arc::clone(&pool), Arc::clone(&meter));
            move || pool.step(&mut toy(many), &meter)
        });
        while meter.episodes() == 0 {
            thread::yield_now();
        }
        let mut short = toy(Wishes { batches: 20, episodes: 400, micros: 10, ..Wishes::default() });
        while short.report().is_none() {
            pool.step(&mut short, &Meter::default()).unwrap();
        }
        assert!(meter.episodes() < MANY / 2, "{} were driven meanwhile", meter.episodes());
        meter.stop();
        assert_eq!(long.join().unwrap(), Err(Halt::Stopped));
    }

    /// The bug to fear: jobs that take a core from the robots.
    #[test]
    #[cfg(target_os = "linux")]
    fn threads_of_lowest_priority_run_only_where_nothing_else_wants_to() {
        // proc_pid_stat(5), field 41; SCHED_IDLE is 5, SCHED_OTHER 0.
        let policy = |priority| {
            let pool = Pool::new(Some(1), priority).unwrap();
            let (sender, receiver) = mpsc::channel();
            pool.0.install(move || {
                sender.send(std::fs::read_to_string("/proc/thread-self/stat").unwrap()).unwrap();
            });
            let stat = receiver.recv().unwrap();
            let after_name = stat.rsplit_once(')').unwrap().1;
            after_name.split_whitespace().nth(41 - 3).unwrap().to_owned()
        };
        assert_eq!(policy(Priority::Lowest), "5");
        assert_eq!(policy(Priority::Normal), "0");
    }
}
