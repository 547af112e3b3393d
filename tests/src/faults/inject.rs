//! How each fault is injected and lifted.

use super::field::Field;
use super::judge::Blindness;
use super::robot::Robot;
use super::schedule::{Injection, Kind};
use crate::http::attempt_within;
use crate::process::Signal;
use futures_util::future::join_all;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rusqlite::Connection;
use std::sync::atomic::Ordering;
use std::time::Duration;
use tokio::time::{Instant, sleep, sleep_until};

/// The file of the server's store.
const STORE: &str = "umwelt.sqlite";

/// How late a lame connection is: beyond the time after which an agent takes a fresh one.
const LAME: std::ops::Range<f64> = 0.3..0.9;

/// How long before a stop a resume is sent in s: it arrives first on a busy machine, too.
const RACE: std::ops::Range<f64> = 0.05..0.15;

/// How long the store is held meanwhile in s, so that the resume is still under way.
const RACE_HELD: f64 = 0.5;

/// Time in s after which it is held.
const RACE_BEGINS: f64 = 0.1;

/// How often in a row.
const RACES: u32 = 4;

/// Time for an answer to a request that came before.
const REPEATED: Duration = Duration::from_secs(5);

/// Makes the injections of one robot, or of the server, one after the other, none before its time.
pub async fn lane(field: &Field, began: Instant, injections: Vec<Injection>) {
    for injection in injections {
        sleep_until(began + Duration::from_secs_f64(injection.from)).await;
        match injection.robot.and_then(|number| field.robots.get(number)) {
            Some(robot) => to_robot(field, robot, &injection).await,
            None => to_server(field, &injection).await,
        }
    }
}

fn says(field: &Field, injection: &Injection, whom: &str) {
    let Injection { number, kind, lasts, .. } = injection;
    field.say(&format!("{number:3} {kind:?} to {whom} for {lasts:.2} s"));
    field.count(|tally| *tally.injected.entry(*kind).or_default() += 1);
}

async fn seconds(seconds: f64) {
    sleep(Duration::from_secs_f64(seconds)).await;
}

async fn to_robot(field: &Field, robot: &Robot, injection: &Injection) {
    field.drives(robot).await;
    robot.is_busy.store(true, Ordering::SeqCst);
    robot.disturb();
    says(field, injection, &robot.id);
    befall(field, robot, injection).await;
    if matches!(injection.kind, Kind::Stop | Kind::StopRace) {
        let _no_one_stops_all = field.everybody.read().await;
        field.resume(robot).await;
    }
    field.goes_on(robot, injection.kind, true).await;
    robot.is_busy.store(false, Ordering::SeqCst);
}

/// Injects a fault into a robot; it is lifted on return.
async fn befall(field: &Field, robot: &Robot, injection: &Injection) {
    let Injection { kind, lasts, .. } = *injection;
    let mut rng = Pcg64Mcg::seed_from_u64(injection.seed);
    match kind {
        Kind::AgentKill => {
            robot.kill_agent();
            seconds(lasts).await;
            tokio::task::block_in_place(|| robot.start_agent());
        }
        Kind::LinkCut | Kind::Silence => {
            robot.cut(true, Blindness::NoLink);
            robot.proxy.cut();
            if kind == Kind::LinkCut {
                robot.proxy.drop_connections();
            }
            seconds(lasts).await;
            robot.proxy.mend();
            robot.cut(false, Blindness::NoLink);
        }
        Kind::HalfOpen => {
            robot.proxy.swallow();
            seconds(lasts).await;
        }
        Kind::Reorder => {
            robot.proxy.lame(Duration::from_secs_f64(rng.random_range(LAME)));
            seconds(lasts).await;
            robot.proxy.lame(Duration::ZERO);
        }
        Kind::Duplicate => repeat(field, robot, &mut rng).await,
        Kind::FrozenTracker | Kind::BlockedWheels | Kind::NoPoses => {
            // A robot that is stopped shows nothing.
            let _no_one_stops_all = field.everybody.read().await;
            match kind {
                Kind::FrozenTracker => robot.body.freeze(),
                Kind::BlockedWheels => robot.body.block(),
                _ => robot.body.darken(),
            }
            seconds(lasts).await;
            robot.body.mend();
        }
        Kind::NewTask => field.give_task(robot).await,
        Kind::Stop => {
            field.stop(robot).await;
            seconds(lasts).await;
            field.stop_holds(robot).await;
        }
        Kind::StopRace => {
            let _no_one_resumes_all = field.everybody.read().await;
            for _ in 0..RACES {
                race(field, robot, RACE_BEGINS + rng.random_range(RACE)).await;
            }
            seconds(lasts).await;
            field.stop_holds(robot).await;
        }
        // Those of the server come to no robot.
        Kind::ServerKill
        | Kind::ServerPause
        | Kind::ServerRestart
        | Kind::DiskFull
        | Kind::StoreHeld
        | Kind::StopAll => {}
    }
}

/// Stops a robot, after so many s, while a resume waits for the store.
async fn race(field: &Field, robot: &Robot, stop_after: f64) {
    let resume = async {
        seconds(RACE_BEGINS).await;
        field.resume(robot).await;
    };
    let stop = async {
        seconds(stop_after).await;
        field.stop(robot).await
    };
    tokio::join!(hold_store(field, RACE_HELD), resume, stop);
    field.stop_holds(robot).await;
}

/// Says again what the robot's agent said in the last two seconds, in any order and all at once.
async fn repeat(field: &Field, robot: &Robot, rng: &mut Pcg64Mcg) {
    let mut bodies = robot.proxy.tap().bodies();
    bodies.shuffle(rng);
    let path = format!("/v1/robots/{}/step", robot.id);
    let server = field.life.address;
    let all = bodies.iter().map(|body| attempt_within(server, "POST", &path, body, REPEATED));
    join_all(all).await;
}

async fn to_server(field: &Field, injection: &Injection) {
    let Injection { kind, lasts, .. } = *injection;
    if let Some(ended) = field.life.ended() {
        field.wrong(ended, |tally| tally.servers_ended += 1);
        field.life.begin_next();
    }
    let everybody = || field.robots.iter();
    everybody().for_each(Robot::disturb);
    says(field, injection, "the server");
    let is_possible = match kind {
        Kind::DiskFull => fill_disk(field, lasts).await,
        Kind::StoreHeld => hold_store(field, lasts).await,
        Kind::StopAll => stop_all(field, lasts).await,
        _ => interrupt(field, kind, lasts).await,
    };
    if !is_possible {
        field.count(|tally| *tally.skipped.entry(kind).or_default() += 1);
    }
    everybody().for_each(Robot::disturb);
    let idle = everybody().filter(|robot| !robot.is_busy.load(Ordering::SeqCst));
    join_all(idle.map(|robot| field.goes_on(robot, kind, false))).await;
}

/// The server dies, ends or stands still, and is back after so many s.
async fn interrupt(field: &Field, kind: Kind, lasts: f64) -> bool {
    field.robots.iter().for_each(|robot| robot.cut(true, Blindness::NoServer));
    match kind {
        Kind::ServerPause => field.life.signal(Signal::Stop),
        Kind::ServerRestart => end(field).await,
        _ => field.life.kill(),
    }
    seconds(lasts).await;
    if kind == Kind::ServerPause {
        field.life.signal(Signal::Continue);
    } else {
        field.life.begin_next();
    }
    field.robots.iter().for_each(|robot| robot.cut(false, Blindness::NoServer));
    true
}

/// The server ends as it is told to.
async fn end(field: &Field) {
    if !field.life.end().await {
        let what = "the server does not end when told to".to_owned();
        field.wrong(what, |tally| tally.servers_hung += 1);
    }
}

/// Everybody is stopped, and resumed after so many s.
async fn stop_all(field: &Field, lasts: f64) -> bool {
    let _no_one_resumes = field.everybody.write().await;
    field.stop_all().await;
    seconds(lasts).await;
    join_all(field.robots.iter().map(|robot| field.stop_holds(robot))).await;
    field.resume_all().await;
    true
}

/// Nothing can be written for so many s; false where this machine does not allow it.
async fn fill_disk(field: &Field, lasts: f64) -> bool {
    let is_full = field.life.fill_disk(true);
    if is_full {
        seconds(lasts).await;
        field.life.fill_disk(false);
    }
    is_full
}

/// Another program writes to the store for so many s; false where it could not.
async fn hold_store(field: &Field, lasts: f64) -> bool {
    let file = field.life.data.file(STORE);
    let held = tokio::task::spawn_blocking(move || {
        let store = Connection::open(file)?;
        store.busy_timeout(Duration::from_secs(2))?;
        store.execute_batch("BEGIN IMMEDIATE")?;
        std::thread::sleep(Duration::from_secs_f64(lasts));
        store.execute_batch("ROLLBACK")
    });
    matches!(held.await, Ok(Ok(())))
}
