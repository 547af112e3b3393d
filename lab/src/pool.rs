//! Drives the episodes of jobs on threads of their own.
//!
//! Invariants: evaluations come in the order of the batch, so the number of threads never shows in a result; a batch that
//! is stopped or fails leaves its job as it was before it; stopping one waits for no more than the episodes that are being
//! driven; jobs that run at the same time share the threads evenly, and none waits for another one's batch.

use crate::evaluator::{Batch, Evaluator, Halt, Meter};
use crate::work::{BatchOutcome, Work};
use rayon::prelude::*;
use std::any::Any;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Once;
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

    /// One batch of the job of this id: what `work` asks for now is evaluated by `evaluator`, be it this pool, and given
    /// back to it. Blocks until that is done.
    ///
    /// # Errors
    /// Where it was stopped or failed; after a panic the work is not to be used any more.
    pub fn step<W: Work>(
        &self,
        job: &str,
        work: &mut W,
        evaluator: &dyn Evaluator<W>,
        meter: &Meter,
    ) -> Result<BatchOutcome<W>, Halt> {
        let index = work.episodes();
        meter.begin(index);
        guarded(|| {
            // All of it in the pool: making a batch and breeding take time too.
            let episodes = self.install(|| work.batch());
            let batch = Batch { job, settings: work.settings(), index, episodes: &episodes };
            let evaluations = evaluator.evaluate(&batch, meter)?;
            self.install(|| work.tell(&evaluations)).map_err(Halt::Refused)
        })?
    }
}

impl<W: Work> Evaluator<W> for Pool {
    fn evaluate(&self, batch: &Batch<'_, W>, meter: &Meter) -> Result<Vec<W::Evaluation>, Halt> {
        let mut evaluations = Vec::with_capacity(batch.episodes.len());
        for turn in batch.episodes.chunks(TURN * self.threads()) {
            evaluations.extend(self.install(|| drive::<W>(batch.settings, turn, meter))?);
        }
        Ok(evaluations)
    }
}

/// Drives some episodes.
fn drive<W: Work>(
    settings: &W::Settings,
    episodes: &[W::Episode],
    meter: &Meter,
) -> Result<Vec<W::Evaluation>, Halt> {
    let evaluate = |episode: &W::Episode| {
        if meter.is_stopped() {
            return Err(Halt::Stopped);
        }
        // Caught here, a panic ends the batch at once; left to the pool it would drive the rest first.
        let evaluation = guarded(|| W::evaluate(settings, episode))?;
        meter.add(1);
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
    use crate::fake_work::{FakeSettings, FakeWork};
    use std::sync::Arc;
    use std::sync::mpsc;
    use std::thread;

    fn fake(settings: FakeSettings) -> FakeWork {
        FakeWork::new(settings).unwrap()
    }

    /// One batch, planned and evaluated by `pool`.
    fn step(
        pool: &Pool,
        work: &mut FakeWork,
        meter: &Meter,
    ) -> Result<BatchOutcome<FakeWork>, Halt> {
        pool.step("job-1", work, pool, meter)
    }

    fn pool(threads: usize) -> Pool {
        Pool::new(Some(threads), Priority::Normal).unwrap()
    }

    /// Guards against evaluations in the order in which they were done.
    #[test]
    fn the_number_of_threads_never_shows() {
        // More than one turn of any of them.
        let settings = FakeSettings { batches: 3, episodes: 1000, ..FakeSettings::default() };
        let run = |threads| {
            let (pool, meter) = (pool(threads), Meter::default());
            let (mut fake, mut parts) = (fake(settings), Vec::new());
            while fake.report().is_none() {
                parts.extend(step(&pool, &mut fake, &meter).unwrap().parts);
                assert_eq!(meter.episodes(), fake.episodes());
            }
            (fake, parts)
        };
        let alone = run(1);
        assert_eq!(alone.1.len(), 3);
        assert_eq!(run(3), alone);
    }

    #[test]
    fn a_batch_that_is_stopped_leaves_its_job_as_it_was() {
        let (mut fake, meter) = (fake(FakeSettings::default()), Meter::default());
        let before = fake.clone();
        meter.stop();
        assert_eq!(step(&pool(2), &mut fake, &meter), Err(Halt::Stopped));
        assert_eq!(fake, before);
        assert_eq!(meter.episodes(), 0);
    }

    /// Guards against a panic that takes the process with it, or a batch that goes on for hours behind it.
    #[test]
    fn a_panic_ends_its_batch_and_nothing_else() {
        let settings = FakeSettings { episodes: 1000, micros: 100, ..FakeSettings::default() };
        let (pool, meter) = (pool(2), Meter::default());
        let halt =
            step(&pool, &mut fake(FakeSettings { panics: true, ..settings }), &meter).unwrap_err();
        assert_eq!(halt.to_string(), "an evaluation failed: no floor under the robot");
        // Saying what happened takes longer than many episodes, but no other turn begins.
        assert!(meter.episodes() < 2 * TURN as u64, "{} were driven", meter.episodes());
        assert!(step(&pool, &mut fake(settings), &meter).is_ok());
    }

    /// An evaluator elsewhere: settings, episodes and evaluations pass as JSON, a batch in two halves.
    struct Elsewhere;

    impl Evaluator<FakeWork> for Elsewhere {
        fn evaluate(&self, batch: &Batch<'_, FakeWork>, _: &Meter) -> Result<Vec<usize>, Halt> {
            fn sent<T: serde::Serialize + serde::de::DeserializeOwned>(value: &T) -> T {
                serde_json::from_str(&serde_json::to_string(value).unwrap()).unwrap()
            }
            assert_eq!((batch.job, batch.index % 1000), ("job-1", 0));
            let settings = sent(batch.settings);
            let halves = batch.episodes.split_at(batch.episodes.len() / 2);
            let evaluate = |episode: &usize| sent(&FakeWork::evaluate(&settings, &sent(episode)));
            let [mut first, second] =
                [halves.0, halves.1].map(|half| half.iter().map(evaluate).collect::<Vec<_>>());
            first.extend(second);
            Ok(first)
        }
    }

    #[test]
    fn it_does_not_show_who_evaluates() {
        let settings = FakeSettings { batches: 3, episodes: 1000, ..FakeSettings::default() };
        let (pool, meter) = (pool(2), Meter::default());
        let run = |evaluator: &dyn Evaluator<FakeWork>| {
            let mut fake = fake(settings);
            while fake.report().is_none() {
                pool.step("job-1", &mut fake, evaluator, &meter).unwrap();
            }
            fake
        };
        assert_eq!(run(&Elsewhere), run(&pool));
    }

    /// Guards against a job of seconds that waits for the batch of another one, which takes hours, be it in a queue
    /// or because a thread that waits for the one has begun the other.
    #[test]
    fn jobs_share_the_threads_and_none_waits_for_the_batch_of_another() {
        let pool = Arc::new(pool(2));
        // Ten seconds of both threads.
        const MANY: u64 = 200_000;
        let many = FakeSettings { episodes: MANY as usize, micros: 100, ..FakeSettings::default() };
        let meter = Arc::new(Meter::default());
        let long = thread::spawn({
            let (pool, meter) = (Arc::clone(&pool), Arc::clone(&meter));
            move || step(&pool, &mut fake(many), &meter)
        });
        while meter.episodes() == 0 {
            thread::yield_now();
        }
        let mut short = fake(FakeSettings {
            batches: 20,
            episodes: 400,
            micros: 10,
            ..FakeSettings::default()
        });
        while short.report().is_none() {
            step(&pool, &mut short, &Meter::default()).unwrap();
        }
        assert!(meter.episodes() < MANY / 2, "{} were driven meanwhile", meter.episodes());
        meter.stop();
        assert_eq!(long.join().unwrap(), Err(Halt::Stopped));
    }

    /// Guards against jobs that take a core from the robots.
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
