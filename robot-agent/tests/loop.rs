//! The whole loop in paused time: the agent, a simulated robot, and a real controller in the same process.

#![allow(clippy::unwrap_used)] // a test that cannot go on fails

mod server;

use server::Server;
use std::sync::{Arc, Mutex};
use std::time::Duration;
use tokio::sync::watch;
use umwelt_agent::drive::Sim;
use umwelt_agent::{AgentError, Clock, Config, Ended, Report, Status, Told, TraceRow, run};
use umwelt_client::api;
use umwelt_core::episode::Scenario;
use umwelt_core::exchange::{IN_FLIGHT, MAX_IN_FLIGHT};
use umwelt_core::geometry::{Pose, Twist, WheelSpeeds};
use umwelt_core::horizon::SLOT;
use umwelt_core::kinematics::{Drive, forward};
use umwelt_core::link::{LinkModel, Outage, Rtt};
use umwelt_core::local::LocalLimits;
use umwelt_core::plant::{PlantModel, Slip};
use umwelt_core::settings::{PoseNoise, Settings};
use umwelt_core::task::{Stage, Task};

/// A camera robot on a hard floor with the thesis's task over `link`.
fn scenario(link: LinkModel) -> Scenario {
    let drive = Drive::default();
    let settings = Settings { drive, noise: PoseNoise::CAMERA, ..Settings::default() };
    Scenario {
        settings,
        plant: PlantModel {
            drive,
            slip: Slip::HARD,
            noise: PoseNoise::CAMERA,
            ..PlantModel::default()
        },
        link,
        task: Task { calibration: None, ..Task::thesis() },
        start: Pose::default(),
        region: None,
        frame: umwelt_core::episode::FRAME,
        time_limit: 120.0,
    }
}

fn normal() -> LinkModel {
    LinkModel::preset("normal").unwrap()
}

/// A run of a scenario's robot against `server`, which can be watched and ended.
struct Run {
    handle: tokio::task::JoinHandle<Result<Report, AgentError>>,
    status: watch::Receiver<Status>,
    end: Option<tokio::sync::oneshot::Sender<()>>,
    rows: Arc<Mutex<Vec<TraceRow>>>,
    max_deviation: Arc<Mutex<f64>>,
}

impl Run {
    fn start(scenario: &Scenario, server: &Arc<Server>, seed: u64) -> Self {
        // As it is, for ever: whoever could change it is gone.
        Self::start_with(scenario, server, seed, watch::channel(LocalLimits::NONE).1)
    }

    fn start_with(
        scenario: &Scenario,
        server: &Arc<Server>,
        seed: u64,
        limits: watch::Receiver<LocalLimits>,
    ) -> Self {
        let (sender, status) = watch::channel(Status::default());
        let (end, ended) = tokio::sync::oneshot::channel::<()>();
        let (rows, max_deviation) = (Arc::default(), Arc::new(Mutex::new(0.0_f64)));
        let trace = {
            let (rows, max_deviation) = (Arc::clone(&rows), Arc::clone(&max_deviation));
            let server = Arc::clone(server);
            move |row: &TraceRow| {
                let rows: &Mutex<Vec<TraceRow>> = &rows;
                rows.lock().unwrap().push(*row);
                if let (Some((from, to)), Some(pose)) = (server.leg(), row.pose) {
                    let mut max = max_deviation.lock().unwrap();
                    *max = max.max(pose.point().distance_to_segment(from, to));
                }
            }
        };
        let config = Config {
            drive: Told::all(&scenario.settings.drive),
            link: Some(scenario.link.clone()),
            seed,
            duration: Some(scenario.time_limit),
            status: Some(sender),
            trace: Some(Box::new(trace)),
            ..Config::new("rover-7".parse().unwrap())
        };
        let sim = Sim::new(scenario.plant, scenario.start, seed)
            .unwrap()
            .with_sensor_delay(scenario.link.sensor_delay)
            .with_limits(limits);
        let shutdown = async move {
            // A sender that is dropped does not end the run.
            if ended.await.is_err() {
                std::future::pending::<()>().await;
            }
        };
        let connect = server.connect();
        let handle = tokio::spawn(run(config, connect, sim, Clock::start(), shutdown));
        Self { handle, status, end: Some(end), rows, max_deviation }
    }

    async fn until(&mut self, what: impl FnMut(&Status) -> bool) {
        self.status.wait_for(what).await.expect("the run goes on");
    }

    async fn end(mut self) -> (Report, Vec<TraceRow>) {
        if let Some(end) = self.end.take() {
            // It may have ended by itself.
            let _ = end.send(());
        }
        let report = self.handle.await.unwrap().unwrap();
        let rows = self.rows.lock().unwrap().clone();
        (report, rows)
    }

    async fn failed(self) -> (AgentError, Vec<TraceRow>) {
        let error = self.handle.await.unwrap().unwrap_err();
        let rows = self.rows.lock().unwrap().clone();
        (error, rows)
    }
}

fn arrived(status: &Status) -> bool {
    status.stage == Some(api::task::Stage::Arrived)
}

fn moves(status: &Status) -> bool {
    forward(&Drive::default(), status.applied).linear > 0.1
}

/// Wheel speeds, body speeds and accelerations never exceed the limits, and the last ones are zero.
///
/// Commands change in steps: over any time, all steps together take no more than that time and one slot.
fn assert_within_limits(rows: &[TraceRow]) {
    let drive = Drive::default();
    let (mut used, mut before, mut at) = (0.0_f64, Twist::ZERO, f64::NEG_INFINITY);
    for row in rows {
        let twist = forward(&drive, row.applied);
        let fastest = row.applied.left.abs().max(row.applied.right.abs());
        assert!(fastest <= drive.max_wheel_speed + 1e-9, "{row:?}");
        assert!(twist.linear.abs() <= drive.max_linear + 1e-9, "{row:?}");
        assert!(twist.angular.abs() <= drive.max_angular + 1e-9, "{row:?}");
        used = (used - (row.time - at)).max(0.0) + drive.change_time(before, twist);
        assert!(used <= SLOT + 1e-5, "too fast a change by {used} s at {row:?} after {before:?}");
        (before, at) = (twist, row.time);
    }
    assert_eq!(rows.last().unwrap().applied, WheelSpeeds::ZERO);
}

#[tokio::test(start_paused = true)]
async fn a_task_is_done_over_the_normal_link() {
    let scenario = scenario(normal());
    let server = Server::new(&scenario);
    let mut run = Run::start(&scenario, &server, 1);
    run.until(arrived).await;
    let observed = run.status.borrow().observed.unwrap();
    assert!(observed.pose.x < -0.49 && observed.pose.x > -0.511);
    let (report, rows) = run.end().await;
    assert_eq!(report.ended, Ended::Shutdown);
    assert!(report.time < 60.0 && report.requests >= report.replies && report.replies > 300);
    assert_within_limits(&rows);
}

/// The same scenario, simulated by core and driven by the agent, on a link that leaves no room for luck.
#[tokio::test(start_paused = true)]
async fn the_run_agrees_with_the_episode() {
    for seed in 1..=5 {
        for calibration in [None, Task::thesis().calibration] {
            let mut scenario = scenario(LinkModel::ordinary(Rtt::Constant(0.04)));
            scenario.task.calibration = calibration;
            let simulated = scenario.run(seed).unwrap();
            assert!(simulated.arrived);
            let server = Server::new(&scenario);
            let mut run = Run::start(&scenario, &server, seed);
            run.until(arrived).await;
            let driven = server.progress();
            let deviation = *run.max_deviation.lock().unwrap();
            run.end().await;
            let ratio = driven.elapsed / simulated.time;
            assert!(
                (ratio - 1.0).abs() < 0.1,
                "{} s, simulated {} s",
                driven.elapsed,
                simulated.time
            );
            assert!((deviation - simulated.max_deviation).abs() < 0.005);
        }
    }
}

/// The link is cut in the middle of a leg: the robot stops by itself, and goes on by itself.
#[tokio::test(start_paused = true)]
async fn a_cut_link_stops_the_robot_and_it_goes_on_afterwards() {
    for seed in 1..=3 {
        let mut scenario = scenario(normal());
        let (start, duration) = (6.0, 20.0);
        scenario.link.outages.push(Outage { start, duration });
        let server = Server::new(&scenario);
        let mut run = Run::start(&scenario, &server, seed);
        run.until(|status| status.time > start && moves(status)).await;
        run.until(|status| !status.connected).await;
        run.until(|status| status.connected).await;
        run.until(arrived).await;
        let (report, rows) = run.end().await;
        assert!(report.time > start + duration && report.time < 60.0);
        let cut = rows.iter().filter(|row| (start + 2.0..start + duration).contains(&row.time));
        assert!(cut.clone().count() > 500);
        assert!(cut.clone().all(|row| row.applied == WheelSpeeds::ZERO));
        assert_within_limits(&rows);
    }
}

#[tokio::test(start_paused = true)]
async fn told_to_end_in_full_drive_it_ramps_to_rest() {
    let scenario = scenario(normal());
    let server = Server::new(&scenario);
    let mut run = Run::start(&scenario, &server, 1);
    run.until(moves).await;
    let told = run.status.borrow().time;
    let (report, rows) = run.end().await;
    assert_eq!(report.ended, Ended::Shutdown);
    let stopping = Drive::default().stopping_time(Twist::new(0.13, 1.25));
    let took = report.time - told;
    assert!(took > 0.2 && took < stopping + 2.0 * SLOT, "{took} s to stop");
    assert_within_limits(&rows);
}

#[tokio::test(start_paused = true)]
async fn its_time_over_it_ramps_to_rest() {
    let scenario = Scenario { time_limit: 4.0, ..scenario(normal()) };
    let server = Server::new(&scenario);
    let run = Run::start(&scenario, &server, 1);
    let report = run.handle.await.unwrap().unwrap();
    assert_eq!(report.ended, Ended::Duration);
    assert!(report.time >= 4.0 && report.time < 5.0);
    assert_within_limits(&run.rows.lock().unwrap());
}

/// It rests at once and within its limits, through a new epoch, a server that is gone and one that is back; let go, it
/// goes on by itself.
#[tokio::test(start_paused = true)]
async fn a_robot_that_holds_rests_whatever_happens_and_goes_on_by_itself() {
    let scenario = scenario(normal());
    let server = Server::new(&scenario);
    let (limits, bumper) = watch::channel(LocalLimits::NONE);
    let mut run = Run::start_with(&scenario, &server, 1, bumper);
    run.until(moves).await;
    limits.send_replace(LocalLimits { hold: true, max_speed: None });
    let stopping = Drive::default().stopping_time(Twist::new(0.13, 1.25));
    tokio::time::sleep(Duration::from_secs_f64(stopping + SLOT)).await;
    let held = *run.status.borrow();
    assert!(held.held && held.applied == WheelSpeeds::ZERO, "{held:?}");
    assert!(server.is_held());
    server.ask_for_a_new_epoch();
    tokio::time::sleep(Duration::from_secs(3)).await;
    assert!(server.is_held() && server.epochs() == 2);
    server.go();
    tokio::time::sleep(Duration::from_secs(5)).await;
    server.come_back();
    tokio::time::sleep(Duration::from_secs(3)).await;
    let resting = *run.status.borrow();
    assert!(server.is_held() && resting.connected);
    assert_eq!(resting.pose, held.pose);
    limits.send_replace(LocalLimits::NONE);
    run.until(arrived).await;
    assert!(!server.is_held());
    let (_, rows) = run.end().await;
    assert_within_limits(&rows);
}

#[tokio::test(start_paused = true)]
async fn a_second_agent_stops_the_first() {
    let scenario = scenario(normal());
    let server = Server::new(&scenario);
    let mut first = Run::start(&scenario, &server, 1);
    first.until(moves).await;
    let mut second = Run::start(&scenario, &server, 2);
    let (error, rows) = first.failed().await;
    assert!(matches!(error, AgentError::Superseded { .. }));
    assert_within_limits(&rows);
    second.until(moves).await;
    second.end().await;
}

#[tokio::test(start_paused = true)]
async fn a_robot_no_one_knows_waits_a_while_and_says_what_to_do() {
    let scenario = scenario(normal());
    let server = Server::new(&scenario);
    server.forget();
    let began = Clock::start();
    let (error, rows) = Run::start(&scenario, &server, 1).failed().await;
    assert!(error.to_string().contains("umwelt robot add rover-7"), "{error}");
    assert!(began.now() > 4.0 && began.now() < 8.0);
    assert!(rows.iter().all(|row| row.applied == WheelSpeeds::ZERO));
}

#[tokio::test(start_paused = true)]
async fn a_robot_that_is_removed_stops_and_goes_on_when_it_is_back() {
    let scenario = scenario(normal());
    let server = Server::new(&scenario);
    let mut run = Run::start(&scenario, &server, 1);
    run.until(moves).await;
    server.forget();
    run.until(|status| status.applied == WheelSpeeds::ZERO).await;
    tokio::time::sleep(Duration::from_secs(10)).await;
    assert_eq!(run.status.borrow().applied, WheelSpeeds::ZERO);
    server.remember();
    run.until(arrived).await;
    let (_, rows) = run.end().await;
    assert_within_limits(&rows);
}

#[tokio::test(start_paused = true)]
async fn asked_for_a_new_epoch_it_counts_anew_and_goes_on() {
    let scenario = scenario(normal());
    let server = Server::new(&scenario);
    let mut run = Run::start(&scenario, &server, 1);
    run.until(moves).await;
    server.ask_for_a_new_epoch();
    run.until(arrived).await;
    assert_eq!(server.epochs(), 2);
    let (_, rows) = run.end().await;
    assert_within_limits(&rows);
}

#[tokio::test(start_paused = true)]
async fn a_server_that_is_gone_for_a_while_is_found_again() {
    let scenario = scenario(normal());
    let server = Server::new(&scenario);
    let mut run = Run::start(&scenario, &server, 1);
    run.until(moves).await;
    server.go();
    run.until(|status| !status.connected && status.applied == WheelSpeeds::ZERO).await;
    let before = server.requests();
    tokio::time::sleep(Duration::from_secs(60)).await;
    // four per connection, a fresh one per second
    let tried = server.requests() - before;
    assert!((60..=300).contains(&tried), "{tried} requests in a minute without a server");
    server.come_back();
    run.until(arrived).await;
    let (_, rows) = run.end().await;
    assert_within_limits(&rows);
}

/// Whatever the server's delay, no connection carries more than four requests, and old ones are closed.
#[tokio::test(start_paused = true)]
async fn few_requests_are_in_flight_on_a_connection() {
    let mut scenario = scenario(LinkModel::ordinary(Rtt::Constant(0.0)));
    scenario.time_limit = 20.0;
    for delay in [0.0, 0.05, 0.2, 0.7, 3.0, 1e6] {
        let server = Server::new(&scenario);
        server.answer_after(delay);
        let run = Run::start(&scenario, &server, 1);
        assert_eq!(run.handle.await.unwrap().unwrap().ended, Ended::Duration);
        let (in_flight, connections) = server.most();
        // One per slot of the round trip, once that is known.
        let most = if delay < 0.1 { IN_FLIGHT } else { MAX_IN_FLIGHT };
        assert!((1..=most as u64).contains(&in_flight), "{in_flight} in flight, {delay} s");
        // three, and for a moment one that is being closed
        assert!((1..=4).contains(&connections), "{connections} connections at a time");
    }
}

/// A real task over the worst link there is: nothing is lost, nothing is too fast.
#[tokio::test(start_paused = true)]
async fn a_bursty_link_is_survived() {
    let scenario =
        Scenario { time_limit: 300.0, ..scenario(LinkModel::preset("wifi-bursty").unwrap()) };
    for seed in 1..=3 {
        let server = Server::new(&scenario);
        let mut run = Run::start(&scenario, &server, seed);
        run.until(arrived).await;
        assert_eq!(server.progress().stage, Stage::Arrived);
        let (_, rows) = run.end().await;
        assert_within_limits(&rows);
    }
}
