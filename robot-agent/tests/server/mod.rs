//! A step service in the same process: a real controller behind the wire types, and every way to be unhelpful.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};
use std::time::Duration;
use umwelt_agent::transport::{Answering, Connect};
use umwelt_client::api::problem::{Detail, Problem, Status, reason};
use umwelt_client::api::{Checked, step};
use umwelt_client::{Error, Failure};
use umwelt_core::controller::Controller;
use umwelt_core::episode::Scenario;
use umwelt_core::geometry::Point;
use umwelt_core::horizon::Horizon;
use umwelt_core::task::Progress;

pub struct Server(Mutex<Inner>);

struct Inner {
    controller: Controller,
    epochs: Vec<u64>,
    newest: u64,
    is_known: bool,
    wants_new_epoch: bool,
    is_gone: bool,
    delay: f64,
    requests: u64,
    connections: u64,
    /// Requests in flight per open connection.
    in_flight: BTreeMap<u64, u64>,
    most_in_flight: u64,
    most_connections: usize,
}

impl Server {
    pub fn new(scenario: &Scenario) -> Arc<Self> {
        let mut controller = Controller::new(scenario.settings);
        controller.set_task(scenario.task.clone());
        Arc::new(Self(Mutex::new(Inner {
            controller,
            epochs: Vec::new(),
            newest: 0,
            is_known: true,
            wants_new_epoch: false,
            is_gone: false,
            delay: 0.0,
            requests: 0,
            connections: 0,
            in_flight: BTreeMap::new(),
            most_in_flight: 0,
            most_connections: 0,
        })))
    }

    fn with<T>(&self, what: impl FnOnce(&mut Inner) -> T) -> T {
        what(&mut self.0.lock().unwrap())
    }

    pub fn connect(self: &Arc<Self>) -> Connect {
        let server = Arc::clone(self);
        Box::new(move || {
            let connection = Arc::new(Connection::open(&server));
            Box::new(move |request| connection.answering(request))
        })
    }

    pub fn leg(&self) -> Option<(Point, Point)> {
        self.with(|inner| inner.controller.leg())
    }

    pub fn progress(&self) -> Progress {
        self.with(|inner| inner.controller.progress())
    }

    pub fn is_held(&self) -> bool {
        self.with(|inner| inner.controller.is_held())
    }

    pub fn forget(&self) {
        self.with(|inner| inner.is_known = false);
    }

    pub fn remember(&self) {
        self.with(|inner| inner.is_known = true);
    }

    pub fn ask_for_a_new_epoch(&self) {
        self.with(|inner| inner.wants_new_epoch = true);
    }

    pub fn go(&self) {
        self.with(|inner| inner.is_gone = true);
    }

    pub fn come_back(&self) {
        self.with(|inner| inner.is_gone = false);
    }

    pub fn answer_after(&self, delay: f64) {
        self.with(|inner| inner.delay = delay);
    }

    pub fn epochs(&self) -> usize {
        self.with(|inner| inner.epochs.len())
    }

    pub fn requests(&self) -> u64 {
        self.with(|inner| inner.requests)
    }

    /// Most requests that were in flight on one connection, and most connections open at a time.
    pub fn most(&self) -> (u64, usize) {
        self.with(|inner| (inner.most_in_flight, inner.most_connections))
    }
}

struct Connection {
    server: Arc<Server>,
    number: u64,
}

impl Connection {
    fn open(server: &Arc<Server>) -> Self {
        let number = server.with(|inner| {
            inner.connections += 1;
            inner.in_flight.insert(inner.connections, 0);
            inner.most_connections = inner.most_connections.max(inner.in_flight.len());
            inner.connections
        });
        Self { server: Arc::clone(server), number }
    }

    fn answering(self: &Arc<Self>, request: step::Request) -> Answering {
        let in_flight = InFlight::new(Arc::clone(self));
        Box::pin(async move {
            let server = &in_flight.0.server;
            let delay = server.with(|inner| {
                inner.requests += 1;
                inner.delay
            });
            if delay > 0.0 {
                tokio::time::sleep(Duration::from_secs_f64(delay)).await;
            }
            server.with(|inner| inner.step(&request))
        })
    }
}

impl Drop for Connection {
    fn drop(&mut self) {
        self.server.with(|inner| inner.in_flight.remove(&self.number));
    }
}

struct InFlight(Arc<Connection>);

impl InFlight {
    fn new(connection: Arc<Connection>) -> Self {
        connection.server.with(|inner| {
            let count = inner.in_flight.get_mut(&connection.number).unwrap();
            *count += 1;
            inner.most_in_flight = inner.most_in_flight.max(*count);
        });
        Self(connection)
    }
}

impl Drop for InFlight {
    fn drop(&mut self) {
        self.0.server.with(|inner| *inner.in_flight.get_mut(&self.0.number).unwrap() -= 1);
    }
}

impl Inner {
    fn step(&mut self, request: &step::Request) -> Result<step::Reply, Error> {
        let what: Box<str> = "POST in this process".into();
        if self.is_gone {
            let (failure, cause) = (Failure::Unreachable, "connection refused".to_owned());
            return Err(Error::Transport { what, failure, cause });
        }
        self.answer(request).map_err(|problem| Error::Problem { what, problem, retry_after: None })
    }

    fn answer(&mut self, request: &step::Request) -> Result<step::Reply, Problem> {
        // What the robot sends is valid, always.
        let core = Checked::new(request.clone()).expect("a valid request").to_core();
        if !self.is_known {
            return Err(Problem::new(Status::NotFound, "there is no robot rover-7"));
        }
        if !self.epochs.contains(&request.epoch) {
            assert!(core.playing.is_none(), "a horizon that another epoch knew: {core:?}");
            self.epochs.push(request.epoch);
            self.newest = 0;
            self.controller.restart_clock();
            self.wants_new_epoch = false;
        }
        if self.wants_new_epoch {
            return Err(Problem::new(Status::FailedPrecondition, "begin a new epoch"));
        }
        if self.epochs.last() != Some(&request.epoch) {
            let detail = Detail::new(reason::EPOCH_SUPERSEDED, "epoch", request.epoch, "");
            return Err(Problem::new(Status::Aborted, "another agent").with(detail));
        }
        let horizon = if core.sequence > self.newest {
            self.newest = core.sequence;
            self.controller.step(&core).horizon
        } else {
            let newest = self.controller.late(&core).expect("a newer request was answered");
            Horizon { answers: core.sequence, ..newest }
        };
        Ok(step::Reply {
            horizon: (&horizon).into(),
            stopped: self.controller.is_stopped(),
            stage: self.controller.progress().stage.into(),
            drive: None,
        })
    }
}
