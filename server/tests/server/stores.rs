//! What the server does when its store fails, hangs or panics, and what it finds again after a restart.

use crate::api::{Api, config, step};
use serde_json::json;
use std::sync::atomic::{AtomicU8, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex};
use tokio::sync::watch;
use umwelt_server::store::{Change, Contents, JobId, MemoryStore, Part, StoreError};
use umwelt_server::{Server, Store};

/// A store that does what it is told to: work, fail in one way or another, or panic.
#[derive(Default)]
pub(crate) struct Faulty {
    memory: MemoryStore,
    fault: AtomicU8,
    posteriors: Mutex<Vec<Change>>,
    saves: AtomicUsize,
}

pub(crate) const WORKS: u8 = 0;
pub(crate) const UNAVAILABLE: u8 = 1;
const DAMAGED: u8 = 2;
const PANICS: u8 = 3;

impl Faulty {
    pub(crate) fn set(&self, fault: u8) {
        self.fault.store(fault, Ordering::SeqCst);
    }

    /// What the robots had learned when that was kept last.
    pub(crate) fn last_posteriors(&self) -> Vec<Change> {
        self.posteriors.lock().unwrap().clone()
    }

    /// How often what robots had learned was kept.
    pub(crate) fn saves(&self) -> usize {
        self.saves.load(Ordering::SeqCst)
    }

    fn check(&self) -> Result<(), StoreError> {
        match self.fault.load(Ordering::SeqCst) {
            UNAVAILABLE => Err(StoreError::Unavailable("disk full".into())),
            DAMAGED => Err(StoreError::Damaged("bad page".into())),
            PANICS => panic!("the store has a bug"),
            _ => Ok(()),
        }
    }
}

impl Store for Faulty {
    fn commit(&self, changes: Vec<Change>) -> Result<(), StoreError> {
        self.check()?;
        if changes.iter().any(|change| matches!(change, Change::PutPosterior(..))) {
            self.saves.fetch_add(1, Ordering::SeqCst);
            self.posteriors.lock().unwrap().clone_from(&changes);
        }
        self.memory.commit(changes)
    }

    fn load(&self) -> Result<Contents, StoreError> {
        self.check()?;
        self.memory.load()
    }

    fn parts(&self, job: JobId, from: usize, limit: usize) -> Result<Vec<Part>, StoreError> {
        self.check()?;
        self.memory.parts(job, from, limit)
    }

    fn checkpoint(&self, job: JobId) -> Result<Option<String>, StoreError> {
        self.check()?;
        self.memory.checkpoint(job)
    }
}

/// A store that holds writers at a gate while it is shut.
#[derive(Default)]
pub(crate) struct Gate {
    memory: MemoryStore,
    is_shut: Mutex<bool>,
    opened: Condvar,
    waiting: watch::Sender<usize>,
}

impl Gate {
    /// Shuts the gate until what is returned is dropped, so that a test that fails leaves no one waiting.
    pub(crate) fn shut(self: &Arc<Self>) -> Shut {
        *self.is_shut.lock().unwrap() = true;
        Shut(Arc::clone(self))
    }

    /// Waits until `count` writers stand at the gate.
    pub(crate) async fn reached(&self, count: usize) {
        self.waiting.subscribe().wait_for(|waiting| *waiting >= count).await.unwrap();
    }

    fn pass(&self, counts: bool) {
        let mut is_shut = self.is_shut.lock().unwrap();
        if *is_shut && counts {
            self.waiting.send_modify(|waiting| *waiting += 1);
        }
        while *is_shut {
            is_shut = self.opened.wait(is_shut).unwrap();
        }
    }
}

/// A gate that is shut.
pub(crate) struct Shut(Arc<Gate>);

impl Drop for Shut {
    fn drop(&mut self) {
        *self.0.is_shut.lock().unwrap() = false;
        self.0.opened.notify_all();
    }
}

impl Store for Gate {
    fn commit(&self, changes: Vec<Change>) -> Result<(), StoreError> {
        // What the robots learn waits as well, but a test that counts writers does not mean it.
        self.pass(!changes.iter().all(|change| matches!(change, Change::PutPosterior(..))));
        self.memory.commit(changes)
    }

    fn load(&self) -> Result<Contents, StoreError> {
        self.memory.load()
    }

    fn parts(&self, job: JobId, from: usize, limit: usize) -> Result<Vec<Part>, StoreError> {
        self.memory.parts(job, from, limit)
    }

    fn checkpoint(&self, job: JobId) -> Result<Option<String>, StoreError> {
        self.memory.checkpoint(job)
    }
}

#[tokio::test]
async fn what_cannot_be_kept_is_refused_and_robots_drive_on() {
    let store = Arc::new(Faulty::default());
    let api = Api::with(config(), store.clone()).await;
    api.add("r").await;
    assert_eq!(api.step(step(7, 1, 10.0, 0.0)).await.code, 200);
    let mut sequence = 1;
    for (fault, code, status) in
        [(UNAVAILABLE, 503, "UNAVAILABLE"), (DAMAGED, 500, "DATA_LOSS"), (PANICS, 500, "INTERNAL")]
    {
        store.set(fault);
        let [robot, task, _] = api.state().await;
        let other = json!({"waypoints": [{"x_m": 0.1, "y_m": 0.0}]});
        for answer in [
            api.put("/v1/robots/r", json!({"horizon_slots": 3})).await,
            api.put("/v1/robots/new", json!({})).await,
            api.put("/v1/robots/r/task", other).await,
            api.delete("/v1/robots/r/task").await,
            api.delete("/v1/robots/r").await,
        ] {
            assert_eq!((answer.code, answer.problem().0.as_str()), (code, status));
        }
        let [robot_then, task_then, _] = api.state().await;
        assert_eq!(robot_then["spec"], robot["spec"]);
        assert_eq!(task_then, task);
        assert_eq!(api.get("/v1/robots/new").await.code, 404);
        sequence += 1;
        assert_eq!(api.step(step(7, sequence, 10.0 + 0.03 * sequence as f64, 0.0)).await.code, 200);
    }
    store.set(WORKS);
    assert_eq!(api.put("/v1/robots/r", json!({"horizon_slots": 3})).await.code, 200);
}

/// Guards against: a full disk keeps an operator from stopping a robot, or lets it go on.
#[tokio::test]
async fn a_stop_works_without_the_store_and_going_on_does_not() {
    let store = Arc::new(Faulty::default());
    let api = Api::with(config(), store.clone()).await;
    api.add("r").await;
    for fault in [UNAVAILABLE, PANICS] {
        store.set(fault);
        assert_eq!(api.post("/v1/robots/r/stop").await.code, 200);
        assert_eq!(api.post("/v1/stop").await.code, 200);
        assert!(api.post("/v1/robots/r/resume").await.code >= 500);
        let all = api.post("/v1/resume").await;
        assert_eq!((all.code, all.problem().0.as_str()), (503, "UNAVAILABLE"));
        assert_eq!(api.get("/v1/robots/r").await.json()["stopped"], true);
        store.set(WORKS);
        assert_eq!(api.post("/v1/robots/r/resume").await.code, 200);
    }
}

/// Guards against: steps wait behind a write to disk.
#[tokio::test]
async fn a_store_that_hangs_slows_neither_steps_nor_stops_nor_other_robots() {
    let gate = Arc::new(Gate::default());
    let api = Api::with(config(), gate.clone()).await;
    api.add("r").await;
    let shut = gate.shut();
    let changing = tokio::spawn({
        let api = api.clone();
        async move { api.put("/v1/robots/r", json!({"horizon_slots": 3})).await }
    });
    gate.reached(1).await;
    assert_eq!(api.step(step(7, 1, 10.0, 0.0)).await.code, 200);
    let stopping = tokio::spawn({
        let api = api.clone();
        async move { api.post("/v1/robots/r/stop").await }
    });
    let stopping_all = tokio::spawn({
        let api = api.clone();
        async move { api.post("/v1/stop").await }
    });
    // It acts at once, whatever the store does.
    let mut sequence = 1;
    loop {
        sequence += 1;
        let reply = api.step(step(7, sequence, 10.0 + 0.03 * sequence as f64, 0.0)).await;
        if reply.json()["stopped"] == true {
            break;
        }
        tokio::task::yield_now().await;
    }
    assert_eq!(stopping_all.await.unwrap().code, 200, "before the store answers");
    drop(shut);
    assert_eq!(changing.await.unwrap().code, 200);
    assert_eq!(stopping.await.unwrap().code, 200);
}

#[tokio::test]
async fn a_restart_finds_robots_tasks_and_stops_again() {
    let store = Arc::new(MemoryStore::default());
    let first = Api::with(config(), store.clone()).await;
    for robot in ["a", "b", "c"] {
        first.add(robot).await;
    }
    first.put("/v1/robots/a", json!({"horizon_slots": 3})).await;
    first.post("/v1/robots/b/stop").await;
    first.delete("/v1/robots/c").await;
    let second = Api::with(config(), store).await;
    for path in ["/v1/robots", "/v1/robots/a/task", "/v1/robots/b/task"] {
        assert_eq!(second.get(path).await.json(), first.get(path).await.json(), "{path}");
    }
    assert_eq!(second.get("/v1/robots/b").await.json()["stopped"], true);
    assert_eq!(second.get("/v1/robots/c").await.code, 404);
}

#[tokio::test]
async fn a_store_that_cannot_be_read_does_not_start_an_empty_server() {
    for fault in [UNAVAILABLE, DAMAGED, PANICS] {
        let store = Arc::new(Faulty::default());
        store.set(fault);
        assert!(Server::with_store(config(), store).await.is_err());
    }
}
