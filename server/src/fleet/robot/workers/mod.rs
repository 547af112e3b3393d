//! Where robots compute: threads of their own, so that no robot's computation holds up connections, stops or health.
//!
//! A robot's task is polled by one of a few threads. A thread that has been at one robot for long is taken for stuck: its
//! robot is shown as failed ([`Vitals`]), and another thread takes its place, so that the others go on. Where it comes
//! back after all, its robot goes on too.
//!
//! A runtime with one thread has nothing to keep apart: robots run in it, as all the rest does.

use super::vitals::Vitals;
use std::cell::RefCell;
use std::collections::VecDeque;
use std::fmt;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::pin::Pin;
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, Wake, Waker};
use std::thread::Builder;
use std::time::Duration;
use tokio::runtime::{Handle, RuntimeFlavor};

/// How often the watchdog looks.
const WATCH_EVERY: Duration = Duration::from_millis(250);

/// Looks at which a thread is seen at one and the same turn before it counts as stuck: a second, of which a process that
/// was paused misses all.
const LOOKS: u32 = 4;

/// Most threads beyond those that are wanted: as many robots may be stuck at a time, or wait for long computations.
const MOST_SPARE: usize = 64;

/// Where the robots of a server compute; cheap to clone.
#[derive(Clone)]
pub(crate) enum Workers {
    /// In the caller's runtime, which has one thread.
    Callers,
    /// On threads of their own.
    Own(Arc<Pool>),
}

impl fmt::Debug for Workers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Callers => "Callers",
            Self::Own(_) => "Own",
        })
    }
}

impl Workers {
    /// Threads for the robots of a server in the runtime that this is called in.
    pub(crate) fn start() -> io::Result<Self> {
        if Handle::current().runtime_flavor() != RuntimeFlavor::MultiThread {
            return Ok(Self::Callers);
        }
        let wanted = std::thread::available_parallelism().map_or(2, |cores| cores.get().max(2));
        Ok(Self::Own(Arc::new(Pool::start(wanted)?)))
    }

    /// Runs a robot's task to its end.
    pub(crate) fn spawn(
        &self,
        vitals: Arc<Vitals>,
        task: impl Future<Output = ()> + Send + 'static,
    ) {
        match self {
            Self::Callers => drop(tokio::spawn(task)),
            Self::Own(pool) => pool.spawn(vitals, Box::pin(task)),
        }
    }
}

/// The threads of a server's robots; they end when it is dropped.
pub(crate) struct Pool(Arc<Shared>);

struct Shared {
    state: Mutex<State>,
    /// Something is to be done, or the pool ends.
    ready: Condvar,
    /// Threads that are to be free for robots at any time.
    wanted: usize,
}

struct State {
    waiting: VecDeque<Arc<Task>>,
    /// One for each thread there ever was; those of threads that ended are taken again.
    seats: Vec<Seat>,
    /// Number of the next turn.
    turn: u64,
    is_closed: bool,
}

/// What one thread does.
enum Seat {
    /// There is no thread.
    Empty,
    /// It waits.
    Free,
    /// It is at a robot.
    Busy(Turn),
}

struct Turn {
    number: u64,
    vitals: Arc<Vitals>,
    /// At how many looks it was seen.
    looks: u32,
    /// It takes long, as was said, or as was seen: another thread stands in for it.
    is_aside: bool,
    is_stuck: bool,
}

thread_local! {
    /// The pool and the seat of this thread, where it is one of a pool.
    static PLACE: RefCell<Option<(Arc<Shared>, usize)>> = const { RefCell::new(None) };
}

/// Does what may take tens of milliseconds; another thread stands in meanwhile, so that other robots do not wait. As many
/// at a time as threads are wanted: more would only slow each other down.
pub(super) fn aside<T>(work: impl FnOnce() -> T) -> T {
    PLACE.with_borrow(|place| {
        if let Some((shared, seat)) = place {
            shared.step_aside(*seat);
        }
    });
    work()
}

/// Lets the others have their turn.
pub(super) async fn end_of_turn() {
    let mut has_waited = false;
    std::future::poll_fn(|context| {
        if has_waited {
            return Poll::Ready(());
        }
        has_waited = true;
        context.waker().wake_by_ref();
        Poll::Pending
    })
    .await;
}

impl Pool {
    fn start(wanted: usize) -> io::Result<Self> {
        let state =
            State { waiting: VecDeque::new(), seats: Vec::new(), turn: 0, is_closed: false };
        let shared = Arc::new(Shared { state: Mutex::new(state), ready: Condvar::new(), wanted });
        let pool = Self(shared);
        for _ in 0..wanted {
            pool.0.add_thread(&mut pool.0.lock())?;
        }
        let watched = Arc::downgrade(&pool.0);
        Builder::new().name("watchdog".to_owned()).spawn(move || {
            loop {
                std::thread::sleep(WATCH_EVERY);
                let Some(shared) = watched.upgrade() else { return };
                if !shared.watch() {
                    return;
                }
            }
        })?;
        Ok(pool)
    }

    fn spawn(&self, vitals: Arc<Vitals>, future: Pin<Box<dyn Future<Output = ()> + Send>>) {
        let task = Task {
            vitals,
            future: Mutex::new(Some(future)),
            state: AtomicU8::new(IDLE),
            shared: Arc::clone(&self.0),
        };
        Arc::new(task).wake();
    }
}

impl Drop for Pool {
    fn drop(&mut self) {
        let mut state = self.0.lock();
        state.is_closed = true;
        // Tasks that wait hold the pool that holds them.
        let waiting = std::mem::take(&mut state.waiting);
        drop(state);
        self.0.ready.notify_all();
        drop(waiting);
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        // Nothing that can panic is done behind the lock.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn add_thread(self: &Arc<Self>, state: &mut State) -> io::Result<()> {
        let empty = state.seats.iter().position(|seat| matches!(seat, Seat::Empty));
        let seat = empty.unwrap_or(state.seats.len());
        let shared = Arc::clone(self);
        Builder::new().name("robots".to_owned()).spawn(move || shared.work(seat))?;
        if empty.is_some() {
            state.seats[seat] = Seat::Free;
        } else {
            state.seats.push(Seat::Free);
        }
        Ok(())
    }

    /// Sees to it that as many threads as are wanted are free for robots.
    fn stand_in(self: &Arc<Self>, state: &mut State) {
        if state.available() < self.wanted
            && state.threads() < self.wanted + MOST_SPARE
            && let Err(error) = self.add_thread(state)
        {
            tracing::error!(%error, "cannot start a thread in place of one that is busy");
        }
    }

    /// What one thread does until the pool ends or has threads enough without it.
    fn work(self: Arc<Self>, seat: usize) {
        PLACE.set(Some((Arc::clone(&self), seat)));
        let mut state = self.lock();
        while !state.is_closed {
            let Some(task) = state.waiting.pop_front() else {
                state = self.ready.wait(state).unwrap_or_else(PoisonError::into_inner);
                continue;
            };
            state.turn += 1;
            let (number, vitals) = (state.turn, Arc::clone(&task.vitals));
            let turn = Turn { number, vitals, looks: 0, is_aside: false, is_stuck: false };
            state.seats[seat] = Seat::Busy(turn);
            drop(state);
            task.run();
            state = self.lock();
            let done = std::mem::replace(&mut state.seats[seat], Seat::Free);
            if let Seat::Busy(turn) = done
                && turn.is_stuck
            {
                drop(state);
                turn.vitals.recover();
                state = self.lock();
            }
            // One that comes back finds another in its place: some stay, for the next time.
            if state.available() > 2 * self.wanted {
                break;
            }
        }
        state.seats[seat] = Seat::Empty;
    }

    /// One look at all threads. Returns whether there is to be another.
    fn watch(self: &Arc<Self>) -> bool {
        let mut state = self.lock();
        let mut stuck = Vec::new();
        for seat in &mut state.seats {
            if let Seat::Busy(turn) = seat {
                turn.looks += 1;
                if turn.looks > LOOKS && !turn.is_stuck {
                    (turn.is_stuck, turn.is_aside) = (true, true);
                    stuck.push((turn.number, Arc::clone(&turn.vitals)));
                }
            }
        }
        for _ in &stuck {
            self.stand_in(&mut state);
        }
        let goes_on = !state.is_closed;
        drop(state);
        for (number, vitals) in stuck {
            vitals.fail();
            // It may have come back between the look and the word.
            if !self.lock().is_at(number) {
                vitals.recover();
            }
        }
        goes_on
    }

    fn step_aside(self: &Arc<Self>, seat: usize) {
        let mut state = self.lock();
        let aside = state.seats.iter().filter(|seat| seat.is_aside()).count();
        if aside < self.wanted
            && let Seat::Busy(turn) = &mut state.seats[seat]
        {
            turn.is_aside = true;
            self.stand_in(&mut state);
        }
    }
}

impl Seat {
    fn is_aside(&self) -> bool {
        matches!(self, Self::Busy(turn) if turn.is_aside)
    }
}

impl State {
    fn threads(&self) -> usize {
        self.seats.iter().filter(|seat| !matches!(seat, Seat::Empty)).count()
    }

    /// Threads that wait, or will be back soon.
    fn available(&self) -> usize {
        self.threads() - self.seats.iter().filter(|seat| seat.is_aside()).count()
    }

    fn is_at(&self, number: u64) -> bool {
        self.seats.iter().any(|seat| matches!(seat, Seat::Busy(turn) if turn.number == number))
    }
}

/// It waits to be woken.
const IDLE: u8 = 0;
/// It is among those that wait for a thread.
const QUEUED: u8 = 1;
/// A thread is at it.
const RUNNING: u8 = 2;
/// A thread is at it, and it was woken meanwhile.
const WOKEN: u8 = 3;

/// One robot's task.
struct Task {
    vitals: Arc<Vitals>,
    /// None once it has ended.
    future: Mutex<Option<Pin<Box<dyn Future<Output = ()> + Send>>>>,
    state: AtomicU8,
    shared: Arc<Shared>,
}

impl Task {
    /// Polls it once.
    fn run(self: Arc<Self>) {
        self.state.store(RUNNING, Ordering::SeqCst);
        let waker = Waker::from(Arc::clone(&self));
        let mut future = self.future.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(pending) = future.as_mut() else { return };
        let mut context = Context::from_waker(&waker);
        // A panic ends the robot's task; what it says of itself goes to the log, the robot's handle sees the rest.
        let polled = catch_unwind(AssertUnwindSafe(|| pending.as_mut().poll(&mut context)));
        if !matches!(polled, Ok(Poll::Pending)) {
            let _ended = catch_unwind(AssertUnwindSafe(|| drop(future.take())));
            return;
        }
        drop(future);
        let was = self.state.compare_exchange(RUNNING, IDLE, Ordering::SeqCst, Ordering::SeqCst);
        if was.is_err() {
            self.queue();
        }
    }

    fn queue(self: Arc<Self>) {
        self.state.store(QUEUED, Ordering::SeqCst);
        let shared = Arc::clone(&self.shared);
        let mut state = shared.lock();
        if !state.is_closed {
            state.waiting.push_back(self);
            drop(state);
            shared.ready.notify_one();
        }
    }
}

impl Wake for Task {
    fn wake(self: Arc<Self>) {
        let next = |state| match state {
            IDLE => Some(QUEUED),
            RUNNING => Some(WOKEN),
            _ => None,
        };
        let woken = self.state.fetch_update(Ordering::SeqCst, Ordering::SeqCst, next);
        if woken == Ok(IDLE) {
            self.queue();
        }
    }
}

#[cfg(test)]
mod tests;
