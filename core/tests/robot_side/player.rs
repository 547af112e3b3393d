//! A robot's side to which everything from outside comes by itself: exchange, actuation, and where its wheels would lead.

use std::fmt::Write;
use umwelt_core::actuation::Actuation;
use umwelt_core::exchange::{Exchange, Observation, Request};
use umwelt_core::geometry::{Pose, WheelSpeeds};
use umwelt_core::horizon::Horizon;
use umwelt_core::kinematics::{self, Drive};
use umwelt_core::local::LocalLimits;
use umwelt_core::time::RobotTime;

/// What reaches the robot.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// A pose from the camera.
    Pose(Observation),
    /// A reply of the server.
    Reply(Box<Horizon>),
    /// What the robot itself allows from now on.
    Restrain(LocalLimits),
}

/// The robot.
pub struct Player {
    drive: Drive,
    exchange: Exchange,
    actuation: Actuation,
    now: f64,
    /// The wheel speeds that it applies.
    pub applied: WheelSpeeds,
    /// What the wheels really do.
    wheels: WheelSpeeds,
    /// Where they have led.
    pose: Pose,
    /// What it has done, one line each, every number to its last digit.
    pub said: String,
}

impl Player {
    /// A robot at rest.
    pub fn new(drive: Drive) -> Self {
        Self {
            drive,
            exchange: Exchange::new(RobotTime::ZERO),
            actuation: Actuation::new(drive, RobotTime::ZERO),
            now: 0.0,
            applied: WheelSpeeds::ZERO,
            wheels: WheelSpeeds::ZERO,
            pose: Pose::default(),
            said: String::new(),
        }
    }

    /// When it next does something by itself.
    pub fn next(&self) -> f64 {
        let request = self.exchange.next_request(RobotTime::new(self.now));
        self.actuation.next_change().earlier(request).seconds()
    }

    /// Takes in what reaches it now.
    pub fn hear(&mut self, now: f64, event: &Event) {
        match event {
            Event::Pose(observation) => drop(self.exchange.observe(*observation)),
            Event::Reply(horizon) => {
                let delay = self.exchange.reply(RobotTime::new(now), horizon.answers);
                let taken = self.actuation.accept(horizon);
                self.say(&format!("{now:?} reply {} {taken:?} {delay:?}", horizon.sequence));
            }
            Event::Restrain(limits) => {
                self.exchange.restrain(*limits);
                self.actuation.restrain(*limits, self.exchange.newest_sequence());
            }
        }
    }

    /// Does what is to be done now; the request to send.
    pub fn advance(&mut self, now: f64) -> Option<Request> {
        let span = now - self.now;
        let (wheels, twist) = kinematics::travel(&self.drive, self.wheels, self.applied, span);
        self.pose = self.pose.then(kinematics::integrate(twist, span));
        (self.wheels, self.now) = (wheels, now);
        let applied = self.actuation.advance(RobotTime::new(now));
        if applied != self.applied {
            let (WheelSpeeds { left, right }, Pose { x, y, heading }) = (applied, self.pose);
            let heading = heading.radians();
            self.say(&format!("{now:?} wheels {left:?} {right:?} at {x:?} {y:?} {heading:?}"));
        }
        self.applied = applied;
        let request = self.exchange.request(RobotTime::new(now), self.actuation.playing())?;
        let Request { sequence, connection, observations, playing, limits, .. } = &request;
        let playing = playing.map(|playing| (playing.horizon, playing.since.seconds()));
        let (count, limits) = (observations.len(), (limits.hold, limits.max_speed));
        self.say(&format!(
            "{now:?} request {sequence} {connection} {count} {playing:?} {limits:?}"
        ));
        Some(request)
    }

    fn say(&mut self, line: &str) {
        writeln!(self.said, "{line}").expect("a text takes every line");
    }
}

/// Plays what was recorded; what the robot did.
pub fn play(record: &str, drive: Drive) -> String {
    let mut player = Player::new(drive);
    let mut events = record.lines().map(read).peekable();
    while let Some((at, _)) = events.peek() {
        let now = at.min(player.next());
        while let Some((_, event)) = events.next_if(|(at, _)| *at <= now) {
            player.hear(now, &event);
        }
        player.advance(now);
    }
    player.said
}

/// An event and its time as a line of a record.
pub fn write(at: f64, event: &Event) -> String {
    match event {
        Event::Pose(Observation { pose, taken }) => {
            let Pose { x, y, heading } = pose;
            let taken = taken.seconds();
            format!("{at:?} pose {taken:?} {x:?} {y:?} {:?}", heading.radians())
        }
        Event::Reply(horizon) => {
            let Horizon { sequence, answers, start, slot, watchdog, speeds } = horizon.as_ref();
            let start = start.seconds();
            let head = format!("{at:?} reply {sequence} {answers} {start:?} {slot:?} {watchdog:?}");
            speeds.iter().fold(head, |line, WheelSpeeds { left, right }| {
                format!("{line} {left:?} {right:?}")
            })
        }
        Event::Restrain(LocalLimits { hold, max_speed }) => {
            let max_speed = max_speed.map_or(String::new(), |max| format!(" {max:?}"));
            format!("{at:?} restrain {hold}{max_speed}")
        }
    }
}

/// Reads a line of a record.
pub fn read(line: &str) -> (f64, Event) {
    let words: Vec<&str> = line.split_whitespace().collect();
    let number = |index: usize| words[index].parse::<f64>().expect("a number");
    let whole = |index: usize| words[index].parse::<u64>().expect("a whole number");
    let event = match words[1] {
        "pose" => {
            let pose = Pose::new(number(3), number(4), number(5));
            Event::Pose(Observation { pose, taken: RobotTime::new(number(2)) })
        }
        "reply" => Event::Reply(Box::new(Horizon {
            sequence: whole(2),
            answers: whole(3),
            start: RobotTime::new(number(4)),
            slot: number(5),
            watchdog: number(6),
            speeds: (7..words.len())
                .step_by(2)
                .map(|index| WheelSpeeds { left: number(index), right: number(index + 1) })
                .collect(),
        })),
        "restrain" => Event::Restrain(LocalLimits {
            hold: words[2] == "true",
            max_speed: (words.len() > 3).then(|| number(3)),
        }),
        other => panic!("nothing is called {other}"),
    };
    (number(0), event)
}
