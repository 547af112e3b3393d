//! What changes where a field is changed: what the contract does not say.

/// The effects of the fields of one body.
pub struct Effects {
    /// The operation: method and path.
    pub body: &'static str,
    /// `(path of the field, effect)`.
    pub fields: &'static [(&'static str, &'static str)],
}

/// All that there are. A field without one has an empty cell.
pub const EFFECTS: [Effects; 6] = [
    Effects { body: "PUT /v1/robots/{robot}", fields: &ROBOT },
    Effects { body: "PUT /v1/robots/{robot}/task", fields: &TASK },
    Effects { body: "PUT /v1/environments/{environment}", fields: &ENVIRONMENT },
    Effects { body: "PUT /v1/priors/{prior}", fields: &PRIOR },
    Effects { body: "POST /v1/evolutions", fields: &EVOLUTION },
    Effects { body: "POST /v1/comparisons", fields: &COMPARISON },
];

/// The effect of a field of a body; empty where none is given.
pub fn effect(body: &str, field: &str) -> &'static str {
    let of_body = EFFECTS.iter().filter(|effects| effects.body == body);
    let mut fields = of_body.flat_map(|effects| effects.fields);
    fields.find(|(name, _)| *name == field).map_or("", |(_, effect)| effect)
}

const ROBOT: [(&str, &str); 41] = [
    (
        "attribution",
        "`sent`: a late packet shows as slip and widens the belief about the floor. `played`: floor and link are told apart.",
    ),
    (
        "drift",
        "On: a heading error per metre, as of unequal wheels, is identified and predicted. Off: it is not, as in the thesis.",
    ),
    (
        "horizon_slots",
        "More slots: longer stalls of the network cost nothing (40 slots are 1.2 s), and a step takes longer to compute. 1: every late packet is felt.",
    ),
    (
        "loop_delay_s",
        "When a new horizon begins: this long after its newest pose. Too small: replies arrive after their beginning. Too large: the robot reacts later.",
    ),
    (
        "method",
        "`fixed-*`: nothing is identified. `statistic`: samples alone. `bayesian`: prior and samples.",
    ),
    (
        "predictor",
        "`monte-carlo` takes up to 90 ms per step and agrees with `moments` to its sampling error.",
    ),
    (
        "prior",
        "A prior worth more samples than the calibration gives outweighs them. `default` is soon outweighed.",
    ),
    (
        "watchdog_s",
        "Longer: a robot with one-slot horizons rides out longer gaps, and drives blind for longer when the link is lost.",
    ),
    (
        "drive.dead_time_s",
        "Too small or too large by more than some 10 ms: the robot is predicted at the wrong place while its speed changes, and hunts.",
    ),
    (
        "drive.kind",
        "`skid-steer`: the two numbers of it count, and the robot turns in place about its turning centre, not about the tracked point.",
    ),
    ("drive.lag_s", "As `dead_time_s`; the sum of both matters most."),
    (
        "drive.max_angular_acceleration_rad_per_s2",
        "Smaller: turns begin and end more gently and take longer.",
    ),
    ("drive.max_angular_rad_per_s", "Smaller: slower turns, and slower driving in tight curves."),
    (
        "drive.max_linear_acceleration_m_per_s2",
        "Smaller: longer ramps, a longer way to rest after a lost link.",
    ),
    ("drive.max_linear_m_per_s", "Larger: shorter tasks, and more metres per unit of delay."),
    ("drive.max_wheel_speed_rad_per_s", "Speeds beyond it are scaled down along the curve."),
    (
        "drive.min_angular_rad_per_s",
        "Too small for the motors: the robot stands at small turns until the watch raises it.",
    ),
    (
        "drive.min_linear_m_per_s",
        "Too small for the motors: the robot stands when it creeps until the watch raises it. Too large: it overshoots at waypoints.",
    ),
    (
        "drive.sideways_m_per_rad",
        "Wrong by some centimetres: the robot aims past its waypoints and corrects on the way, or turns again before them.",
    ),
    (
        "drive.track_width_m",
        "Wrong by some percent: every turn is wrong by as much until the channel `turn` is identified.",
    ),
    (
        "drive.turn_by_speed_s_per_m",
        "Wrong: curves at speed are wider or tighter than planned, turns in place are not.",
    ),
    (
        "drive.wheel_radius_m",
        "Wrong by some percent: every distance is wrong by as much until the channel `forward` is identified.",
    ),
    (
        "noise.heading_rad",
        "Larger: longer windows of motion, fewer samples, and a wider prediction.",
    ),
    (
        "noise.position_m",
        "Too small: the noise of the camera counts as slip. Larger: longer windows of motion, and waypoints are met less exactly.",
    ),
    ("predictor (monte-carlo).agents", "More: less sampling error, more time per step."),
    ("predictor (monte-carlo).cell_m", "Larger cells: coarser variances."),
    ("predictor (monte-carlo).seed", "The same seed gives the same predictions."),
    (
        "steering.alpha_m_per_s",
        "Below `drive.max_linear_m_per_s` it caps the speed; derived it is above.",
    ),
    ("steering.stop_radius_m", "Larger: the robot stops earlier and less exactly."),
    ("steering.tolerance_m", "As `tolerance_m` of a task."),
    ("steering.turn_beyond_rad", "Smaller: more stops to turn in place; larger: wider curves."),
    (
        "steering.turn_tolerance_rad",
        "Below `min_angular_rad_per_s` times the spread of the delay the robot turns to and fro.",
    ),
    ("variance.heading_rad2", "Smaller: an unsure robot turns and drives more slowly."),
    (
        "variance.position_m2",
        "Smaller: an unsure robot drives more slowly. At the default it acts on bad floors and wide priors only.",
    ),
    (
        "prior.forward",
        "Mean below 0: the robot is expected to fall short, so it drives for longer.",
    ),
    ("prior.lateral", "A wide one slows the robot down without improving its aim."),
    ("prior.turn", "As `forward`, for turns."),
    ("prior.drift.k", "Larger: samples move the mean less."),
    ("prior.drift.mu", "Beyond -0.7 and 0.5 a learned mean is clamped."),
    (
        "prior.drift.r",
        "Larger: samples move the variance less. 2 or less: the variance has no expectation, and the robot is unsure until samples come.",
    ),
    ("prior.drift.s", "Larger: a wider prediction, so a slower robot."),
];

const TASK: [(&str, &str); 16] = [
    (
        "calibration",
        "Without one the environment is learned on the way; the first leg is driven by the prior.",
    ),
    ("calibration.rotations", "More: more samples of `turn`, more time."),
    (
        "calibration.rotate_s",
        "Shorter than some 0.4 s: the motion is hardly ever constant, and few samples come.",
    ),
    (
        "calibration.straight_m",
        "0: `forward`, `lateral` and `drift` stay as the prior has them until the task begins.",
    ),
    (
        "calibration.angular_rad_per_s",
        "Faster: the noise of the camera weighs less; beyond the drive's limit it is cut.",
    ),
    ("calibration.pause_s", "Longer: more time."),
    (
        "check",
        "The robot wiggles for some 20 s and reports what is wrong with it or its tracker (`docs/check.md`).",
    ),
    ("check.drive_s", "Longer: more room, and a noisier tracker suffices."),
    ("check.speed_share", "Larger: motors that stand at small speeds turn."),
    (
        "square",
        "The robot drives a square both ways, open loop, and reports how wheels and track differ from the description (`docs/calibrate.md`).",
    ),
    ("square.runs", "More: the floor's chance weighs less, and it takes longer."),
    ("square.side_m", "Longer: the noise of the camera weighs less, and it needs more room."),
    ("square.speed_share", "Slower: wheels slip less, and it takes longer."),
    ("max_deviation_m", "Farther from the leg the robot rests and shows `off-path`."),
    ("reverse", "`true`: shorter ways back, driven with the tail ahead."),
    (
        "tolerance_m",
        "Below some times the noise of the camera the robot may never be seen to arrive.",
    ),
];

const ENVIRONMENT: [(&str, &str); 10] = [
    (
        "fitness",
        "`normal`: faster is fitter within `max_deviation_m`. `bad`: less deviation is fitter within `max_time_s`.",
    ),
    ("weight", "Fitness is the weighted mean over environments."),
    ("link", "A preset is kept as its numbers."),
    ("slip", "A preset is kept as its numbers."),
    (
        "link.in_order",
        "`true`: a late packet holds back all behind it. `false`: late packets are overtaken and hardly matter.",
    ),
    ("link.late.after_late", "Above `probability`: late packets come in bursts."),
    ("link.late.extra_s", "400 ms in the thesis."),
    ("link.late.probability", "5 % in the thesis."),
    (
        "link.silences",
        "Longer than horizon and watchdog together: the robot stops and goes on by itself.",
    ),
    ("link.sensor_delay_s", "Part of every loop delay; 130 ms in the thesis."),
];

const PRIOR: [(&str, &str); 1] =
    [("note", "Shown beside the prior. An evolution writes where it comes from.")];

const EVOLUTION: [(&str, &str); 14] = [
    (
        "preset",
        "`thesis`: 100 generations of 100, two environments, one slot. `quick`: 12 of 24. `default`: six environments, 20 slots.",
    ),
    (
        "optimizer",
        "`genetic` and `cma-es` search for fitness; `empirical-bayes` for the likeliest samples.",
    ),
    ("population", "Episodes grow in proportion."),
    ("generations", "Episodes grow in proportion. A checkpoint is written after each."),
    ("trials", "More: fitness is less noisy, so selection errs less. Episodes grow in proportion."),
    ("selection_trials", "More: the champion is chosen with less luck."),
    ("report_trials", "More: narrower intervals in the report."),
    (
        "horizon_slots",
        "A prior is evolved for this number of slots; with another it may be worse than the default.",
    ),
    ("environments", "The champion is made for these and no others."),
    (
        "expansion",
        "Larger: children stray farther from their parents. 1.2 in the thesis. `genetic` only.",
    ),
    ("elites", "0 in the thesis. `genetic` only."),
    ("crossover_probability", "49 % in the thesis. `genetic` only."),
    ("mutation_probability", "2 % in the thesis. `genetic` only."),
    ("seed", "Another seed may find another champion."),
];

const COMPARISON: [(&str, &str); 4] = [
    ("methods", "Fewer: less time."),
    ("trials", "Four times as many halve the intervals."),
    ("scenario", "See [compare.md](compare.md)."),
    ("prior", "For `bayesian` alone; `bayesian-default`, `-flat` and `-empirical` have their own."),
];
