//! Everything that is there: server, robots, what is counted, and what an operator can do.

use super::judge::Judge;
use super::life::Life;
use super::report::Tally;
use super::robot::Robot;
use super::schedule::Kind;
use crate::http::{Answer, attempt_within};
use serde_json::{Value, json};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;
use tokio::sync::RwLock;
use tokio::time::sleep;
use umwelt_agent::Clock;

/// Time for an answer to an operator.
const ANSWER: Duration = Duration::from_secs(15);

/// A way in m after which a robot has moved again.
const GOES_ON: f64 = 0.02;

/// Time between two looks at how far it has come.
const LOOK: Duration = Duration::from_millis(50);

/// Time in s without a motion after which the operator looks whether it needs a resume.
const RETRY_AFTER_S: f64 = 3.0;

/// Time in s after which a robot that has not moved will not: several times what any fault here takes to be over.
const GIVEN_UP: f64 = 60.0;

/// Names of alarms, wherever a robot's description shows them.
const ALARMS: [&str; 7] =
    ["stuck", "frozen", "no-poses", "frame-mismatch", "off-path", "jumping", "not-as-described"];

/// What a robot shows that did not move and is tried at higher speeds.
const RAISED: &str = "raised";

/// All of it.
#[derive(Debug)]
pub struct Field {
    /// The clock of all judges.
    pub clock: Clock,
    /// The robots.
    pub robots: Vec<Robot>,
    /// The server.
    pub life: Life,
    /// Whoever stops all robots holds it, so that no one resumes one meanwhile.
    pub everybody: RwLock<()>,
    /// How often everybody was stopped or resumed.
    pub stops_of_all: AtomicU64,
    /// Whether violations are said at once.
    pub is_quiet: bool,
    tally: Mutex<Tally>,
}

impl Field {
    /// A server and so many robots that are registered and have a task; their agents run.
    pub async fn prepare(robots: usize, seed: u64, is_quiet: bool) -> Self {
        let clock = Clock::host();
        let life = tokio::task::block_in_place(Life::begin);
        let mut all = Vec::with_capacity(robots);
        for number in 1..=robots {
            all.push(Robot::new(number, life.address, clock, seed).await);
        }
        let field = Self {
            clock,
            robots: all,
            life,
            everybody: RwLock::new(()),
            stops_of_all: AtomicU64::new(0),
            is_quiet,
            tally: Mutex::default(),
        };
        for robot in &field.robots {
            let spec = json!({"noise": {"position_m": 0.0005, "heading_rad": 0.003}});
            field.call("PUT", &format!("/v1/robots/{}", robot.id), &spec).await;
            field.give_task(robot).await;
            tokio::task::block_in_place(|| robot.start_agent());
        }
        field
    }

    /// Counts something.
    pub fn count<T>(&self, count: impl FnOnce(&mut Tally) -> T) -> T {
        // A count is made or not: what is behind a poisoned lock is whole.
        count(&mut self.tally.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Says what happens, on standard error.
    pub fn say(&self, what: &str) {
        if !self.is_quiet {
            eprintln!("{:9.2}  {what}", self.clock.now());
        }
    }

    /// Counts something that must not be and says it.
    pub fn wrong(&self, what: String, count: impl FnOnce(&mut Tally)) {
        self.say(&what);
        self.count(|tally| {
            count(tally);
            tally.told.push(what);
        });
    }

    async fn call(&self, method: &str, path: &str, body: &Value) -> Option<Answer> {
        let body = if body.is_null() { String::new() } else { body.to_string() };
        attempt_within(self.life.address, method, path, body.as_bytes(), ANSWER).await
    }

    async fn post(&self, path: &str) -> Option<Answer> {
        self.call("POST", path, &json!({})).await
    }

    /// What the server says about a robot.
    async fn look(&self, robot: &Robot) -> Option<Value> {
        let answer = self.call("GET", &format!("/v1/robots/{}", robot.id), &Value::Null).await?;
        (answer.code == 200).then(|| answer.json())
    }

    /// Gives a robot a new task.
    pub async fn give_task(&self, robot: &Robot) {
        let path = format!("/v1/robots/{}/task", robot.id);
        let answer = self.call("PUT", &path, &robot.next_task()).await;
        robot.has_next_task();
        if answer.is_some_and(|answer| matches!(answer.code, 200 | 201)) {
            robot.body.judge(|judge, now| judge.begins_anew(now));
        }
    }

    /// Stops a robot; whether that was acknowledged.
    pub async fn stop(&self, robot: &Robot) -> bool {
        let sent = robot.body.now();
        let answer = self.post(&format!("/v1/robots/{}/stop", robot.id)).await;
        let Some(answer) = answer.filter(|answer| answer.code == 200) else { return false };
        if answer.json()["kept"] == Value::Bool(false) {
            self.count(|tally| tally.stops_not_kept += 1);
            return false;
        }
        robot.body.judge(|judge, now| judge.stop_acknowledged(sent, now));
        true
    }

    /// Looks whether a robot whose stop was acknowledged is still told to rest.
    pub async fn stop_holds(&self, robot: &Robot) {
        let Some(shown) = self.look(robot).await else { return };
        if shown["stopped"] == Value::Bool(false) {
            robot.body.judge(|judge, now| judge.is_not_stopped(now));
        }
    }

    /// Lets a robot go on.
    pub async fn resume(&self, robot: &Robot) {
        robot.body.judge(|judge, now| judge.resumes(now));
        // Refused or not answered, no one knows whether it goes on; it is asked again where it does not.
        let _ = self.post(&format!("/v1/robots/{}/resume", robot.id)).await;
    }

    /// Stops all robots; those that the answer names were not told.
    pub async fn stop_all(&self) {
        let sent = self.clock.now();
        let answer = self.tell_all("/v1/stop").await;
        let Some(answer) = answer.filter(|answer| answer.code == 200) else { return };
        let answer = answer.json();
        if answer["kept"] == Value::Bool(false) {
            self.count(|tally| tally.stops_not_kept += 1);
            return;
        }
        for robot in self.robots.iter().filter(|robot| !names(&answer, &robot.id)) {
            robot.body.judge(|judge, now| judge.stop_acknowledged(sent, now));
        }
    }

    /// Lets all robots go on.
    pub async fn resume_all(&self) {
        for robot in &self.robots {
            robot.body.judge(|judge, now| judge.resumes(now));
        }
        let _ = self.tell_all("/v1/resume").await;
    }

    /// Says something to all robots. It may take effect at any time between the two counts: what is seen meanwhile says
    /// nothing of afterwards.
    async fn tell_all(&self, path: &str) -> Option<Answer> {
        self.stops_of_all.fetch_add(1, Ordering::SeqCst);
        let answer = self.post(path).await;
        self.stops_of_all.fetch_add(1, Ordering::SeqCst);
        answer
    }

    /// Resumes a robot that stands; whether it was stopped or had raised an alarm.
    async fn nudge(&self, robot: &Robot) -> bool {
        let _no_one_stops_all = self.everybody.read().await;
        let Some(shown) = self.look(robot).await else { return false };
        let needed = shown["stopped"] == Value::Bool(true) || alarm(&shown).is_some();
        self.resume(robot).await;
        needed
    }

    /// Waits until a robot drives.
    pub async fn drives(&self, robot: &Robot) {
        let (mut way, mut nudged) = (robot.body.way(), self.clock.now());
        let given_up = nudged + GIVEN_UP;
        while self.clock.now() < given_up {
            sleep(10 * LOOK).await;
            if robot.body.way() > way + GOES_ON {
                return;
            }
            way = robot.body.way();
            if self.clock.now() > nudged + RETRY_AFTER_S {
                nudged = self.clock.now();
                self.nudge(robot).await;
            }
        }
    }

    /// Waits until a robot has moved again after a fault of `kind`. Where another fault comes meanwhile no one knows
    /// what this one took; whoever `stays` waits all the same.
    pub async fn goes_on(&self, robot: &Robot, kind: Kind, stays: bool) {
        let (way, lifted, before) = (robot.body.way(), self.clock.now(), robot.disturbances());
        let (mut last, mut since, mut nudged, mut resumed) = (before, lifted, lifted, false);
        loop {
            sleep(LOOK).await;
            let now = self.clock.now();
            if robot.body.way() >= way + GOES_ON {
                return self.recovered(kind, (last == before).then_some(now - lifted), resumed);
            }
            if robot.disturbances() != last {
                if !stays {
                    return self.recovered(kind, None, false);
                }
                (last, since, nudged) = (robot.disturbances(), now, now);
            } else if now > nudged + RETRY_AFTER_S {
                resumed |= self.nudge(robot).await;
                nudged = self.clock.now();
            } else if now > since + GIVEN_UP {
                let shown = self.look(robot).await.unwrap_or_default();
                let what = format!("{} does not go on after {kind:?}: {shown}", robot.id);
                return self.wrong(what, |tally| {
                    tally.recoveries.entry(kind).or_default().missing += 1;
                });
            }
        }
    }

    fn recovered(&self, kind: Kind, time: Option<f64>, resumed: bool) {
        self.count(|tally| {
            let recoveries = tally.recoveries.entry(kind).or_default();
            match time {
                Some(time) => recoveries.times.push(time),
                None => recoveries.interrupted += 1,
            }
            recoveries.resumed += u64::from(resumed);
        });
    }

    /// Looks after the robots for ever: whoever is done gets a new task, an agent that ended is started anew.
    pub async fn look_after(&self) {
        let mut seen: Vec<(u64, u64, Option<&str>)> = vec![(0, 0, None); self.robots.len()];
        loop {
            for (robot, (task, leg, alarmed)) in self.robots.iter().zip(&mut seen) {
                sleep(LOOK).await;
                if let Some(ended) = robot.agent_ended() {
                    self.wrong(ended, |tally| tally.agents_ended += 1);
                    tokio::task::block_in_place(|| robot.start_agent());
                }
                let before = robot.task();
                let Some(shown) = self.look(robot).await else { continue };
                if shown.pointer("/watch/state").is_some_and(|state| state == RAISED) {
                    robot.body.judge(Judge::is_tried);
                }
                let now = alarm(&shown);
                if let Some(name) = now.filter(|_| now != *alarmed) {
                    self.say(&format!("{} raises {name}", robot.id));
                    self.count(|tally| *tally.alarms.entry(name.to_owned()).or_default() += 1);
                }
                *alarmed = now;
                let stage = shown.pointer("/task/stage").and_then(Value::as_str);
                if matches!(stage, None | Some("idle" | "arrived")) {
                    self.give_task(robot).await;
                    continue;
                }
                let at = shown.pointer("/task/leg").and_then(Value::as_u64).unwrap_or(0);
                // What was learned in the last seconds before a kill may be lost: a leg, not the task.
                if *task == before && *leg > 2 && at + 2 < *leg {
                    let what = format!("{} was at leg {leg} and is at leg {at}", robot.id);
                    self.wrong(what, |tally| tally.resets += 1);
                }
                (*task, *leg) = (before, at);
            }
        }
    }

    /// Everything that was counted.
    pub fn into_tally(self) -> Tally {
        self.tally.into_inner().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Whether `value` names a robot anywhere.
fn names(value: &Value, robot: &str) -> bool {
    match value {
        Value::String(text) => text == robot,
        Value::Array(values) => values.iter().any(|value| names(value, robot)),
        Value::Object(fields) => fields.values().any(|value| names(value, robot)),
        _ => false,
    }
}

/// The alarm that a robot shows.
fn alarm(shown: &Value) -> Option<&'static str> {
    ALARMS.into_iter().find(|alarm| names(&shown["watch"], alarm))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_alarm_is_found_where_a_robot_shows_it_and_nowhere_else() {
        let alarmed = json!({"robot": "stuck", "watch": {"alarm": {"name": "frozen"}}});
        assert_eq!(alarm(&alarmed), Some("frozen"));
        assert_eq!(alarm(&json!({"robot": "stuck", "watch": null})), None);
        assert_eq!(alarm(&json!({"robot": "stuck"})), None);
        assert!(names(&json!({"not_told": ["robot-1"]}), "robot-1"));
        assert!(!names(&json!({"not_told": ["robot-10"]}), "robot-1"));
    }
}
