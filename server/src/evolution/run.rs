//! Evaluates evolutions on threads of their own.
//!
//! Invariants: evaluations are told in the order of the jobs, so the number of threads never shows in a result; a
//! batch that is stopped or fails leaves the evolution as it was before it; whoever stops one waits for no more than
//! the episodes that are being driven. Nothing here knows the store, the wire or the async part of the server.

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
use umwelt_core::evolution::{Evaluation, Evolution, Generation, Job, TellError};

/// How threads stand beside the others of the system.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Priority {
    /// As all others.
    Normal,
    /// They run where nothing else wants to (`SCHED_IDLE`): a step preempts them at once.
    #[default]
    Lowest,
}

/// Threads that evaluate.
#[derive(Debug)]
pub(crate) struct Pool {
    threads: rayon::ThreadPool,
    evaluate: fn(&Evolution, &Job) -> Evaluation,
}

/// How far a batch has got, and whether it is to go on: shared between who evaluates and who watches.
#[derive(Debug, Default)]
pub(crate) struct Meter {
    episodes: AtomicU64,
    stopped: AtomicBool,
}

impl Meter {
    /// Episodes that the evolution has driven, those of the batch that is going on included.
    pub(crate) fn episodes(&self) -> u64 {
        self.episodes.load(Ordering::Relaxed)
    }

    /// Ends the batch as soon as the episodes that are being driven have ended.
    pub(crate) fn stop(&self) {
        self.stopped.store(true, Ordering::Relaxed);
    }

    fn is_stopped(&self) -> bool {
        self.stopped.load(Ordering::Relaxed)
    }
}

/// Why a batch did not come to its end.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum Halt {
    /// Somebody stopped it; the evolution is as it was before the batch.
    #[error("it was stopped")]
    Stopped,
    /// An evaluation panicked.
    #[error("an evaluation failed: {0}")]
    Panicked(String),
    /// The evaluations were not those that the evolution had asked for.
    #[error(transparent)]
    Told(#[from] TellError),
}

impl Pool {
    /// So many threads, all cores where none are said.
    ///
    /// # Errors
    /// Where the system does not give the threads.
    pub(crate) fn new(threads: Option<usize>, priority: Priority) -> io::Result<Self> {
        let threads = rayon::ThreadPoolBuilder::new()
            .num_threads(threads.unwrap_or(0))
            .thread_name(|index| format!("evolution-{index}"))
            .start_handler(move |_| {
                if priority == Priority::Lowest {
                    lower();
                }
            })
            .build()
            .map_err(|error| io::Error::other(format!("no threads for evolutions: {error}")))?;
        Ok(Self { threads, evaluate: Evolution::evaluate })
    }

    /// Does `work` on a thread of the pool, and so at its priority. Blocks until it is done.
    pub(super) fn install<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        self.threads.install(work)
    }

    /// How many threads there are.
    pub(crate) fn threads(&self) -> usize {
        self.threads.current_num_threads()
    }

    /// Drives what `evolution` asks for now and tells it. Returns the generation that ended with it, if one did.
    /// Blocks until that is done.
    ///
    /// # Errors
    /// Where it was stopped or failed; after a panic the evolution is not to be used any more.
    pub(crate) fn step(
        &self,
        evolution: &mut Evolution,
        meter: &Meter,
    ) -> Result<Option<Generation>, Halt> {
        meter.episodes.store(evolution.episodes(), Ordering::Relaxed);
        guarded(|| {
            // All of it in the pool: making jobs and breeding take time too.
            self.threads.install(|| {
                let jobs = evolution.jobs();
                let evaluations = self.evaluate(evolution, &jobs, meter)?;
                Ok(evolution.tell(&evaluations)?)
            })
        })?
    }

    /// The same with another way to evaluate.
    #[cfg(test)]
    pub(super) fn evaluating(self, evaluate: fn(&Evolution, &Job) -> Evaluation) -> Self {
        Self { evaluate, ..self }
    }

    fn evaluate(
        &self,
        evolution: &Evolution,
        jobs: &[Job],
        meter: &Meter,
    ) -> Result<Vec<Evaluation>, Halt> {
        let evaluate = |job: &Job| {
            if meter.is_stopped() {
                return Err(Halt::Stopped);
            }
            // Caught here, a panic ends the batch at once; left to the pool it would drive the rest first.
            let evaluation = guarded(|| (self.evaluate)(evolution, job))?;
            meter.episodes.fetch_add(1, Ordering::Relaxed);
            Ok(evaluation)
        };
        // An episode takes milliseconds: each is worth its own place in the queue.
        jobs.par_iter().with_max_len(1).map(evaluate).collect()
    }
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

/// Puts the calling thread behind all others.
fn lower() {
    static WARNED: Once = Once::new();
    let policy = ThreadSchedulePolicy::Normal(NormalThreadSchedulePolicy::Idle);
    let lowered = set_thread_priority_and_policy(thread_native_id(), ThreadPriority::Min, policy);
    if let Err(error) = lowered {
        WARNED.call_once(|| {
            tracing::warn!(%error, "evolutions run at normal priority and may delay the control of robots");
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use std::sync::mpsc;
    use umwelt_core::evolution::EvolutionSettings;

    fn small() -> Evolution {
        let quick = EvolutionSettings::preset("quick").unwrap();
        Evolution::new(EvolutionSettings {
            population: 4,
            generations: 2,
            trials: 1,
            selection_trials: 2,
            report_trials: 3,
            ..quick
        })
        .unwrap()
    }

    fn pool(threads: usize) -> Pool {
        Pool::new(Some(threads), Priority::Normal).unwrap()
    }

    /// The bug to fear: evaluations told in the order in which they were done.
    #[test]
    fn the_number_of_threads_never_shows() {
        let run = |threads| {
            let (pool, meter) = (pool(threads), Meter::default());
            let (mut evolution, mut generations) = (small(), Vec::new());
            while evolution.report().is_none() {
                generations.extend(pool.step(&mut evolution, &meter).unwrap());
                assert_eq!(meter.episodes(), evolution.episodes());
            }
            (evolution, generations)
        };
        let alone = run(1);
        assert_eq!(alone.1.len(), 2);
        assert_eq!(run(3), alone);
    }

    #[test]
    fn a_batch_that_is_stopped_leaves_the_evolution_as_it_was() {
        let (mut evolution, meter) = (small(), Arc::new(Meter::default()));
        let before = evolution.clone();
        meter.stop();
        assert_eq!(pool(2).step(&mut evolution, &meter), Err(Halt::Stopped));
        assert_eq!(evolution, before);
        assert_eq!(meter.episodes(), 0);
    }

    /// The bug to fear: a panic that takes the process with it, or a batch that goes on for hours behind it.
    #[test]
    fn a_panic_ends_its_batch_and_nothing_else() {
        static HAS_FAILED: AtomicBool = AtomicBool::new(false);
        fn first_fails(evolution: &Evolution, job: &Job) -> Evaluation {
            assert!(HAS_FAILED.swap(true, Ordering::SeqCst), "no floor under the robot");
            evolution.evaluate(job)
        }
        let pool = pool(2).evaluating(first_fails);
        let (mut evolution, meter) = (small(), Meter::default());
        let jobs = evolution.jobs().len() as u64;
        let halt = pool.step(&mut evolution, &meter).unwrap_err();
        assert_eq!(halt.to_string(), "an evaluation failed: no floor under the robot");
        assert!(meter.episodes() < jobs / 4, "{} of {jobs} were driven", meter.episodes());
        assert!(pool.evaluating(Evolution::evaluate).step(&mut small(), &meter).is_ok());
    }

    /// The bug to fear: evolutions that take a core from the robots.
    #[test]
    #[cfg(target_os = "linux")]
    fn threads_of_lowest_priority_run_only_where_nothing_else_wants_to() {
        // proc_pid_stat(5), field 41; SCHED_IDLE is 5, SCHED_OTHER 0.
        let policy = |priority| {
            let pool = Pool::new(Some(1), priority).unwrap();
            let (sender, receiver) = mpsc::channel();
            pool.threads.install(move || {
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
