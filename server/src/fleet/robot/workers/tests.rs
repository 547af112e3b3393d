use super::*;
use crate::fleet::feed::Feed;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::Instant;
use tokio::sync::mpsc;

/// More than anything here takes on a busy machine.
const LONG: Duration = Duration::from_secs(60);

fn vitals(id: &str) -> Arc<Vitals> {
    let feed = Feed::new();
    Arc::new(Vitals::new(id.parse().unwrap(), feed.ring(), feed))
}

fn until(what: impl Fn() -> bool) {
    let begun = Instant::now();
    while !what() {
        assert!(begun.elapsed() < LONG, "it does not come");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// A task that answers what it is sent, and computes until it is released where it is sent 0.
fn echo(pool: &Pool, vitals: &Arc<Vitals>) -> (mpsc::Sender<u32>, Receiver<u32>, Sender<()>) {
    let (ask, mut asked) = mpsc::channel(64);
    let (answer, answers) = channel();
    let (release, released) = channel::<()>();
    pool.spawn(
        Arc::clone(vitals),
        Box::pin(async move {
            while let Some(number) = asked.recv().await {
                if number == 0 {
                    let _ = released.recv();
                }
                let _ = answer.send(number);
            }
        }),
    );
    (ask, answers, release)
}

#[test]
fn every_wake_is_heard() {
    let pool = Pool::start(2).unwrap();
    let tasks: Vec<_> = (0..20).map(|_| echo(&pool, &vitals("r"))).collect();
    for number in 1..500 {
        for (ask, _, _) in &tasks {
            ask.blocking_send(number).unwrap();
        }
        if number % 3 == 0 {
            std::thread::yield_now();
        }
    }
    for (_, answers, _) in &tasks {
        for number in 1..500 {
            assert_eq!(answers.recv_timeout(LONG), Ok(number));
        }
    }
}

/// Guards against: as many robots that compute for ever as there are threads, and no one is answered any more.
#[test]
fn stuck_tasks_are_seen_and_take_no_thread_from_others() {
    let pool = Pool::start(2).unwrap();
    let stuck: Vec<_> = (0..6)
        .map(|_| {
            let vitals = vitals("stuck");
            let task = echo(&pool, &vitals);
            task.0.blocking_send(0).unwrap();
            (vitals, task)
        })
        .collect();
    let well = vitals("well");
    let (ask, answers, _) = echo(&pool, &well);
    ask.blocking_send(1).unwrap();
    assert_eq!(answers.recv_timeout(LONG), Ok(1));
    until(|| stuck.iter().all(|(vitals, _)| vitals.has_failed()));
    assert!(!well.has_failed());
    // Their computations end after all: they go on.
    for (_, (ask, answers, release)) in &stuck {
        release.send(()).unwrap();
        assert_eq!(answers.recv_timeout(LONG), Ok(0));
        ask.blocking_send(7).unwrap();
        assert_eq!(answers.recv_timeout(LONG), Ok(7));
    }
    until(|| stuck.iter().all(|(vitals, _)| !vitals.has_failed()));
    // Those that stood in do not stay for ever.
    until(|| {
        ask.blocking_send(1).unwrap();
        answers.recv_timeout(LONG).is_ok() && pool.0.lock().threads() <= 4 + 1
    });
}

#[test]
fn a_task_that_panics_ends_alone() {
    let pool = Pool::start(1).unwrap();
    let (ask, asked) = mpsc::channel::<()>(1);
    let panics = async move {
        let _asked = asked;
        panic!("as a bug would");
    };
    pool.spawn(vitals("p"), Box::pin(panics));
    until(|| ask.is_closed());
    let (ask, answers, _) = echo(&pool, &vitals("r"));
    ask.blocking_send(3).unwrap();
    assert_eq!(answers.recv_timeout(LONG), Ok(3));
}

/// Guards against: a server that was dropped and whose threads go on.
#[test]
fn threads_end_with_the_pool() {
    let pool = Pool::start(3).unwrap();
    let (ask, _answers, _) = echo(&pool, &vitals("r"));
    let shared = Arc::downgrade(&pool.0);
    drop(ask);
    drop(pool);
    until(|| shared.strong_count() == 0);
}
