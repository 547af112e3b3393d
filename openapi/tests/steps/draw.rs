//! Robots, tasks and what comes to their controllers, over the whole of the contract's ranges.

use proptest::prelude::*;
use proptest::sample::select;
use serde_json::{Value, json};
use umwelt_api::prior::built_in;
use umwelt_api::robot::{self, MAX_INTEGER};
use umwelt_api::{Range, step, task as wire_task};
use umwelt_core::exchange::{MAX_DELIVERIES, MAX_OBSERVATIONS};
use umwelt_core::horizon::{MAX_SLOTS, SLOT};
use umwelt_core::settings::Settings;
use umwelt_core::task::Task;

/// Robot time of the first request in s: the whole range of the contract.
const CLOCK: Range = step::TIME;

/// A pause between two requests in s: from a burst to a day. Farther jumps come beside it.
const PAUSE: Range = Range::new(1e-6, 86_400.0, "s");

/// Most agents of a Monte Carlo: as many tell whether a limit holds, and are quick.
const AGENTS: usize = 16;

/// Any value of `range`, its ends among them.
fn within(range: Range) -> impl Strategy<Value = f64> + Clone {
    prop_oneof![8 => range.min..=range.max, 1 => Just(range.min), 1 => Just(range.max)]
}

/// Any order of magnitude of a positive `range`.
fn magnitude(range: Range) -> impl Strategy<Value = f64> + Clone {
    (range.min.ln()..=range.max.ln()).prop_map(move |ln| ln.exp().clamp(range.min, range.max))
}

/// Robot time at the first request in s.
pub fn clock() -> impl Strategy<Value = f64> {
    let size = magnitude(Range::new(1e-3, CLOCK.max, "s"));
    prop_oneof![
        2 => Just(0.0),
        2 => within(CLOCK),
        2 => (size, any::<bool>()).prop_map(|(size, ahead)| if ahead { size } else { -size }),
    ]
}

/// A robot as someone may describe it.
pub fn robot() -> impl Strategy<Value = Settings> {
    let choices = (
        select(vec!["fixed-normal", "fixed-bad", "statistic", "bayesian"]),
        select(vec!["sent", "played"]),
        any::<bool>(),
        prop_oneof![Just(20), 1..=MAX_SLOTS],
        prop_oneof![Just(0.23), within(robot::LOOP_DELAY)],
        prop_oneof![Just(0.3), Just(0.0), robot::MIN_WATCHDOG..=robot::WATCHDOG.max],
    );
    (choices, drive(), noise(), predictor(), steering(), prior()).prop_filter_map(
        "a drive whose wheels are too slow for its smallest speed",
        |(choices, drive, noise, predictor, (variance, steering), prior)| {
            let (method, attribution, drift, slots, loop_delay_s, watchdog_s) = choices;
            let spec = json!({
                "method": method, "attribution": attribution, "drift": drift, "horizon_slots": slots,
                "loop_delay_s": loop_delay_s, "watchdog_s": watchdog_s, "drive": drive, "noise": noise,
                "predictor": predictor, "variance": variance, "steering": steering, "prior": prior,
            });
            let read = robot::Description::read_known(spec.to_string().as_bytes(), built_in);
            read.ok().map(|(_, settings)| settings)
        },
    )
}

/// Drives of a toy, of our own kind, of a service robot, of a truck, and any other.
fn drive() -> impl Strategy<Value = Value> {
    let drive = |radius: f64, track: f64, wheel: f64, linear: f64, angular: f64| {
        json!({
            "wheel_radius_m": radius, "track_width_m": track, "max_wheel_speed_rad_per_s": wheel,
            "max_linear_m_per_s": linear, "min_linear_m_per_s": 0.1 * linear,
            "max_angular_rad_per_s": angular, "min_angular_rad_per_s": 0.1 * angular,
            "max_linear_acceleration_m_per_s2": 2.0 * linear,
            "max_angular_acceleration_rad_per_s2": 2.0 * angular,
        })
    };
    let scales = vec![
        json!({}),
        json!({"lag_s": 0.1, "dead_time_s": 0.04}),
        json!({"kind": "skid-steer", "sideways_m_per_rad": 0.05, "turn_by_speed_s_per_m": -1.5}),
        json!({"kind": "skid-steer", "sideways_m_per_rad": -0.03, "turn_by_speed_s_per_m": 2.0}),
        drive(0.005, 0.02, 20.0, 0.08, 4.0),
        drive(0.033, 0.16, 6.6, 0.22, 2.8),
        drive(0.08, 0.35, 14.0, 1.0, 2.0),
        drive(0.15, 1.3, 16.0, 2.0, 1.0),
    ];
    let positive = (
        magnitude(robot::WHEEL_RADIUS),
        magnitude(robot::TRACK_WIDTH),
        magnitude(robot::WHEEL_SPEED),
        (magnitude(robot::LINEAR_SPEED), 1e-3..=1.0f64),
        (magnitude(robot::ANGULAR_SPEED), 1e-3..=1.0f64),
        magnitude(robot::LINEAR_ACCELERATION),
        magnitude(robot::ANGULAR_ACCELERATION),
    );
    let any = (positive, within(robot::LAG), within(robot::LAG)).prop_map(
        |((radius, track, wheel, linear, angular, speeding, turning), lag, dead_time)| {
            let slowest = |(fastest, part): (f64, f64), range: Range| {
                (fastest * part).clamp(range.min, fastest)
            };
            json!({
                "wheel_radius_m": radius, "track_width_m": track, "max_wheel_speed_rad_per_s": wheel,
                "max_linear_m_per_s": linear.0,
                "min_linear_m_per_s": slowest(linear, robot::LINEAR_SPEED),
                "max_angular_rad_per_s": angular.0,
                "min_angular_rad_per_s": slowest(angular, robot::ANGULAR_SPEED),
                "max_linear_acceleration_m_per_s2": speeding,
                "max_angular_acceleration_rad_per_s2": turning,
                "lag_s": lag, "dead_time_s": dead_time,
            })
        },
    );
    prop_oneof![3 => select(scales), 1 => any]
}

fn noise() -> impl Strategy<Value = Value> {
    let any = (within(robot::POSITION_NOISE), within(robot::HEADING_NOISE));
    prop_oneof![Just((0.0, 0.0)), Just((5e-4, 3e-3)), any]
        .prop_map(|(position, heading)| json!({"position_m": position, "heading_rad": heading}))
}

fn predictor() -> impl Strategy<Value = Value> {
    let monte_carlo = (1..=AGENTS, magnitude(robot::CELL), 0..=MAX_INTEGER).prop_map(
        |(agents, cell, seed)| {
            json!({"kind": "monte-carlo", "agents": agents, "cell_m": cell, "seed": seed})
        },
    );
    prop_oneof![5 => Just(json!({"kind": "moments"})), 1 => monte_carlo]
}

fn steering() -> impl Strategy<Value = (Value, Value)> {
    let variance = (magnitude(robot::POSITION_VARIANCE), magnitude(robot::HEADING_VARIANCE));
    let variance = variance
        .prop_map(|(position, heading)| json!({"position_m2": position, "heading_rad2": heading}));
    let turn = (robot::TURN.min..1.0f64, 1.0..=robot::TURN.max);
    let law = (magnitude(robot::ALPHA), magnitude(robot::STOP_RADIUS), turn).prop_map(
        |(alpha, radius, (tolerance, beyond))| {
            json!({
                "alpha_m_per_s": alpha, "stop_radius_m": radius,
                "turn_tolerance_rad": tolerance, "turn_beyond_rad": beyond,
            })
        },
    );
    (prop_oneof![2 => Just(json!({})), 1 => variance], prop_oneof![2 => Just(json!({})), 1 => law])
}

fn prior() -> impl Strategy<Value = Value> {
    let channel = (
        within(robot::MU),
        magnitude(robot::WEIGHT),
        magnitude(robot::WEIGHT),
        magnitude(robot::SUM_OF_SQUARES),
    );
    let channel = channel.prop_map(|(mu, k, r, s)| json!({"mu": mu, "k": k, "r": r, "s": s}));
    let own = (channel.clone(), channel.clone(), channel.clone(), channel).prop_map(
        |(forward, lateral, turn, drift)| {
            json!({"forward": forward, "lateral": lateral, "turn": turn, "drift": drift})
        },
    );
    let named = select(vec!["default", "flat", "thesis"]).prop_map(Value::from);
    prop_oneof![3 => named, 1 => own]
}

/// A task, near or anywhere.
pub fn task() -> impl Strategy<Value = Task> {
    let near = Range::new(-0.5, 0.5, "m");
    let point = |range: Range| (within(range), within(range));
    let points = prop_oneof![
        3 => prop::collection::vec(point(near), 1..5),
        1 => prop::collection::vec(point(wire_task::COORDINATE), 1..5),
    ];
    let calibration = (
        0..=wire_task::MAX_ROTATIONS,
        within(wire_task::ROTATION_SPEED),
        within(wire_task::ROTATION_TIME),
        within(wire_task::PAUSE),
        within(wire_task::STRAIGHT),
    );
    let calibration = calibration.prop_map(|(rotations, angular, rotate, pause, straight)| {
        json!({
            "rotations": rotations, "angular_rad_per_s": angular, "rotate_s": rotate,
            "pause_s": pause, "straight_m": straight,
        })
    });
    let calibration = prop_oneof![4 => Just(Value::Null), 1 => Just(json!({})), 1 => calibration];
    let tolerance = prop_oneof![Just(0.01), magnitude(wire_task::TOLERANCE)];
    (points, tolerance, any::<bool>(), calibration).prop_map(
        |(points, tolerance, reverse, calibration)| {
            let waypoints: Vec<Value> =
                points.into_iter().map(|(x, y)| json!({"x_m": x, "y_m": y})).collect();
            let spec = json!({
                "waypoints": waypoints, "tolerance_m": tolerance, "reverse": reverse,
                "calibration": calibration,
            });
            wire_task::Spec::read(spec.to_string().as_bytes()).unwrap().to_core(0.01)
        },
    )
}

/// Where a pose shows the robot.
#[derive(Clone, Debug)]
pub enum Seen {
    /// About where its commands have led it, this far off in m, m and rad.
    AsTold(f64, f64, f64),
    /// Anywhere: x, y in m and heading in rad, wrapped or not.
    Anywhere(f64, f64, f64),
}

fn seen() -> impl Strategy<Value = Seen> {
    let off = -1e-3..1e-3f64;
    let as_told = (off.clone(), off.clone(), off).prop_map(|(x, y, h)| Seen::AsTold(x, y, h));
    let place = || within(wire_task::COORDINATE);
    let near = || -0.5..0.5f64;
    let heading = || prop_oneof![-4.0..4.0f64, within(step::HEADING)];
    prop_oneof![
        6 => as_told,
        1 => (near(), near(), heading()).prop_map(|(x, y, h)| Seen::Anywhere(x, y, h)),
        1 => (place(), place(), heading()).prop_map(|(x, y, h)| Seen::Anywhere(x, y, h)),
    ]
}

/// What the robot says that it plays.
#[derive(Clone, Debug)]
pub enum Plays {
    /// Nothing yet.
    Nothing,
    /// The horizon sent so many before the newest, since so many s.
    Sent(usize, f64),
    /// One of any number, known or not, since so many s.
    Any(u64, f64),
}

fn plays() -> impl Strategy<Value = Plays> {
    let ago = || prop_oneof![0.0..0.5f64, magnitude(PAUSE)];
    prop_oneof![
        2 => Just(Plays::Nothing),
        4 => (0..8usize, ago()).prop_map(|(back, ago)| Plays::Sent(back, ago)),
        1 => (0..=MAX_INTEGER, ago()).prop_map(|(horizon, ago)| Plays::Any(horizon, ago)),
    ]
}

/// A request, its times and numbers counted from the one before.
#[derive(Clone, Debug)]
pub struct Said {
    /// Time in s since the request before.
    pub pause: f64,
    /// How much its sequence grows.
    pub gap: u64,
    /// Age in s of the newest pose, and the poses, newest first, each with the time in s to the next older one.
    pub age: f64,
    pub poses: Vec<(Seen, f64)>,
    /// Replies that arrived: how many requests ago, and their loop delay in s.
    pub deliveries: Vec<(u64, f64)>,
    pub plays: Plays,
    /// Whether the robot itself holds, and the speed in m/s that it allows.
    pub allows: (bool, Option<f64>),
}

impl Said {
    /// What an agent says in every slot of a robot that goes as told.
    pub fn regular() -> Self {
        Self {
            pause: SLOT,
            gap: 1,
            age: 0.13,
            poses: vec![(Seen::AsTold(0.0, 0.0, 0.0), SLOT)],
            deliveries: Vec::new(),
            plays: Plays::Nothing,
            allows: (false, None),
        }
    }
}

fn pause() -> impl Strategy<Value = f64> {
    let jump = magnitude(Range::new(1.0, CLOCK.max - CLOCK.min, "s"));
    prop_oneof![12 => Just(SLOT), 4 => 0.0..0.5f64, 3 => magnitude(PAUSE), 1 => jump]
}

fn allows() -> impl Strategy<Value = (bool, Option<f64>)> {
    let slower = prop_oneof![0.0..1.0f64, within(step::MAX_SPEED)].prop_map(Some);
    prop_oneof![12 => Just((false, None)), 1 => Just((true, None)), 2 => (Just(false), slower)]
}

fn said() -> impl Strategy<Value = Said> {
    let gap = prop_oneof![
        8 => Just(1.0),
        1 => magnitude(Range::new(1.0, MAX_INTEGER as f64, "")),
    ];
    let apart = || prop_oneof![0.001..0.2f64, magnitude(PAUSE)];
    let few = prop::collection::vec((seen(), apart()), 0..3);
    let many = prop::collection::vec((seen(), apart()), 0..=MAX_OBSERVATIONS);
    let age = prop_oneof![3 => Just(0.13), 2 => 0.0..0.5f64, 1 => magnitude(PAUSE)];
    let delay = prop_oneof![0.0..0.6f64, within(step::DELIVERY_DELAY)];
    let delivery = (prop_oneof![4 => 0..8u64, 1 => 0..=MAX_INTEGER], delay);
    let deliveries = prop_oneof![
        4 => prop::collection::vec(delivery.clone(), 0..2),
        1 => prop::collection::vec(delivery, 0..=MAX_DELIVERIES),
    ];
    let poses = prop_oneof![4 => few, 1 => many];
    (pause(), gap, age, poses, deliveries, plays(), allows()).prop_map(
        |(pause, gap, age, poses, deliveries, plays, allows)| Said {
            pause,
            gap: gap as u64,
            age,
            poses,
            deliveries,
            plays,
            allows,
        },
    )
}

/// What comes to a controller.
#[derive(Clone, Debug)]
pub enum Act {
    /// Requests in a row.
    Steps(Vec<Said>),
    /// A request that a newer one has overtaken.
    Late(Said),
    /// Stop, go on, another task, none.
    Stop,
    Resume,
    Task(Task),
    Cancel,
    /// The agent begins anew, with its clock at this time in s.
    RestartClock(f64),
    /// The server begins anew.
    Restore,
    /// The robot is described anew.
    Settings(Box<Settings>),
    /// What was learned is forgotten.
    Forget,
}

/// One of them.
pub fn act() -> impl Strategy<Value = Act> {
    prop_oneof![
        12 => prop::collection::vec(said(), 1..16).prop_map(Act::Steps),
        1 => said().prop_map(Act::Late),
        3 => Just(Act::Stop),
        4 => Just(Act::Resume),
        2 => task().prop_map(Act::Task),
        1 => Just(Act::Cancel),
        1 => clock().prop_map(Act::RestartClock),
        1 => Just(Act::Restore),
        1 => robot().prop_map(|settings| Act::Settings(Box::new(settings))),
        1 => Just(Act::Forget),
    ]
}
