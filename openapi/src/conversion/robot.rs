//! A robot's description and the settings of its controller.

use crate::body;
use crate::check::Check;
use crate::named::Known;
use crate::problem::{Problems, reason};
use crate::robot::{
    Attribution, Description, Drive, Kind, Method, NOISE, Noise, Pose, Predictor, PriorChoice,
    Said, Spec, Steering, VarianceLimits,
};
use umwelt_core::derived::{self, Quantity};
use umwelt_core::exchange;
use umwelt_core::horizon::SLOT;
use umwelt_core::kinematics::{self, SkidSteer};
use umwelt_core::settings::{self, PoseNoise, Settings};

impl From<kinematics::Drive> for Drive {
    fn from(core: kinematics::Drive) -> Self {
        let (kind, skid) = match core.kind {
            kinematics::Kind::Differential => (Kind::Differential, SkidSteer::default()),
            kinematics::Kind::SkidSteer(skid) => (Kind::SkidSteer, skid),
        };
        Self {
            wheel_radius_m: core.wheel_radius,
            track_width_m: core.track_width,
            max_wheel_speed_rad_per_s: core.max_wheel_speed,
            max_linear_m_per_s: core.max_linear,
            min_linear_m_per_s: core.min_linear,
            max_angular_rad_per_s: core.max_angular,
            min_angular_rad_per_s: core.min_angular,
            max_linear_acceleration_m_per_s2: core.max_linear_acceleration,
            max_angular_acceleration_rad_per_s2: core.max_angular_acceleration,
            lag_s: core.lag,
            dead_time_s: core.dead_time,
            kind,
            turn_by_speed_s_per_m: skid.turn_by_speed,
            sideways_m_per_rad: skid.sideways,
        }
    }
}

impl Drive {
    /// The drive in core's terms, whatever its values: what a program keeps was checked when it came.
    pub fn convert(self) -> kinematics::Drive {
        kinematics::Drive {
            wheel_radius: self.wheel_radius_m,
            track_width: self.track_width_m,
            unequal: 0.0,
            max_wheel_speed: self.max_wheel_speed_rad_per_s,
            max_linear: self.max_linear_m_per_s,
            min_linear: self.min_linear_m_per_s,
            max_angular: self.max_angular_rad_per_s,
            min_angular: self.min_angular_rad_per_s,
            max_linear_acceleration: self.max_linear_acceleration_m_per_s2,
            max_angular_acceleration: self.max_angular_acceleration_rad_per_s2,
            lag: self.lag_s,
            dead_time: self.dead_time_s,
            kind: match self.kind {
                Kind::Differential => kinematics::Kind::Differential,
                Kind::SkidSteer => kinematics::Kind::SkidSteer(SkidSteer {
                    turn_by_speed: self.turn_by_speed_s_per_m,
                    sideways: self.sideways_m_per_rad,
                }),
            },
        }
    }
}

impl From<PoseNoise> for Noise {
    fn from(core: PoseNoise) -> Self {
        Self { position_m: core.position, heading_rad: core.heading }
    }
}

impl Noise {
    /// The noise in core's terms, whatever its values: what a program keeps was checked when it came.
    pub fn convert(self) -> PoseNoise {
        PoseNoise { position: self.position_m, heading: self.heading_rad }
    }
}

impl From<settings::Method> for Method {
    fn from(core: settings::Method) -> Self {
        match core {
            settings::Method::FixedNormal => Self::FixedNormal,
            settings::Method::FixedBad => Self::FixedBad,
            settings::Method::Statistic => Self::Statistic,
            settings::Method::Bayesian => Self::Bayesian,
            settings::Method::Adaptive => Self::Adaptive,
        }
    }
}

impl From<Method> for settings::Method {
    fn from(wire: Method) -> Self {
        match wire {
            Method::FixedNormal => Self::FixedNormal,
            Method::FixedBad => Self::FixedBad,
            Method::Statistic => Self::Statistic,
            Method::Bayesian => Self::Bayesian,
            Method::Adaptive => Self::Adaptive,
        }
    }
}

impl From<settings::Attribution> for Attribution {
    fn from(core: settings::Attribution) -> Self {
        match core {
            settings::Attribution::Sent => Self::Sent,
            settings::Attribution::Played => Self::Played,
        }
    }
}

impl From<Attribution> for settings::Attribution {
    fn from(wire: Attribution) -> Self {
        match wire {
            Attribution::Sent => Self::Sent,
            Attribution::Played => Self::Played,
        }
    }
}

impl From<settings::PredictorKind> for Predictor {
    fn from(core: settings::PredictorKind) -> Self {
        match core {
            settings::PredictorKind::Moments => Self::Moments,
            settings::PredictorKind::MonteCarlo { agents, cell, seed } => {
                Self::MonteCarlo { agents, cell_m: cell, seed }
            }
        }
    }
}

impl Predictor {
    /// The predictor in core's terms, unchecked.
    fn convert(self) -> settings::PredictorKind {
        match self {
            Self::Moments => settings::PredictorKind::Moments,
            Self::MonteCarlo { agents, cell_m, seed } => {
                settings::PredictorKind::MonteCarlo { agents, cell: cell_m, seed }
            }
        }
    }
}

impl From<settings::VarianceLimits> for VarianceLimits {
    fn from(core: settings::VarianceLimits) -> Self {
        Self { position_m2: core.position, heading_rad2: core.heading }
    }
}

impl From<settings::SteeringSettings> for Steering {
    fn from(core: settings::SteeringSettings) -> Self {
        Self {
            alpha_m_per_s: core.alpha,
            stop_radius_m: core.stop_radius,
            tolerance_m: core.tolerance,
            turn_tolerance_rad: core.turn_tolerance,
            turn_beyond_rad: core.turn_beyond,
        }
    }
}

impl From<&Settings> for Spec {
    /// With the prior itself, not its name.
    fn from(core: &Settings) -> Self {
        Self {
            drive: core.drive.into(),
            noise: core.noise.into(),
            method: core.method.into(),
            attribution: core.attribution.into(),
            drift: core.drift,
            horizon_slots: core.slots,
            loop_delay_s: core.loop_delay,
            sensor_delay_s: core.sensor_delay,
            watchdog_s: core.watchdog,
            predictor: core.predictor.into(),
            variance: core.variance.into(),
            steering: core.steering.into(),
            prior: PriorChoice::Inline(core.prior.into()),
        }
    }
}

impl Description {
    /// Reads the body of a PUT where the priors are known: what was said, and the settings that it means, with what follows
    /// from it. Slots are 30 ms long.
    ///
    /// # Errors
    /// Every field that is unknown, out of its range, or contradicts another, and a prior that no one knows.
    ///
    /// ```
    /// use umwelt_api::{prior, robot::Description};
    /// let body = br#"{"drive": {"wheel_radius_m": 0.033, "max_linear_m_per_s": 0.26}}"#;
    /// let (_, settings) = Description::read_known(body, prior::built_in)?;
    /// assert_eq!(settings.steering.alpha, 0.4);
    ///
    /// let body = br#"{"horizon_slots": 68, "drive": {"lag": 0.1}}"#;
    /// let problems = Description::read_known(body, prior::built_in).unwrap_err();
    /// let fields: Vec<_> = problems.details().iter().map(|detail| detail.field.as_str()).collect();
    /// assert_eq!(fields, ["drive.lag", "horizon_slots"]);
    /// # Ok::<(), umwelt_api::Problems>(())
    /// ```
    pub fn read_known(
        json: &[u8],
        known: impl Fn(&str) -> Known<settings::Prior>,
    ) -> Result<(Self, Settings), Problems> {
        let read = body::read_said(json, |Said(spec), said, check| {
            let prior = spec.resolve_prior(known, check);
            // What is wrong by itself contradicts nothing.
            let sound = Self::of(said.clone()).without(&check.fields());
            let settings = sound.complete(sound.spec().convert(prior));
            Spec::from(&settings).check_agreement(check);
            settings
        })?;
        Ok((Self::of(read.said), read.resolved))
    }

    /// These settings, all of them known already, with what is identified because it was not said.
    pub fn identify(&self, settings: Settings) -> Settings {
        let says = |quantity| self.says(path(quantity));
        let follows_link = derived::follows_link(says);
        let identifies_lag = derived::identifies_lag(says);
        let identifies_dead_band = derived::identifies_dead_band(says);
        let identifies_noise = !NOISE.iter().any(|field| self.says(field));
        Settings {
            follows_link,
            identifies_lag,
            identifies_dead_band,
            identifies_noise,
            ..settings
        }
    }

    /// These settings with what follows from the rest and was not said.
    fn complete(&self, settings: Settings) -> Settings {
        let complete = derived::complete(settings, |quantity| self.says(path(quantity)));
        // What was said is in its range already, or refused.
        let mut spec = Spec::from(&complete);
        spec.hold_derived();
        let settings = self.identify(spec.convert(complete.prior));
        if self.says("attribution") {
            return settings;
        }
        let attribution = match settings.method {
            settings::Method::Adaptive => settings::Attribution::Played,
            _ => settings::Attribution::Sent,
        };
        Settings { attribution, ..settings }
    }
}

/// The field of a spec that holds what may follow from the rest: one of [`DERIVED`](crate::robot::DERIVED).
pub(super) fn path(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::MaxLinear => "drive.max_linear_m_per_s",
        Quantity::MinLinear => "drive.min_linear_m_per_s",
        Quantity::MaxAngular => "drive.max_angular_rad_per_s",
        Quantity::MinAngular => "drive.min_angular_rad_per_s",
        Quantity::LinearAcceleration => "drive.max_linear_acceleration_m_per_s2",
        Quantity::AngularAcceleration => "drive.max_angular_acceleration_rad_per_s2",
        Quantity::MaxWheelSpeed => "drive.max_wheel_speed_rad_per_s",
        Quantity::Alpha => "steering.alpha_m_per_s",
        Quantity::StopRadius => "steering.stop_radius_m",
        Quantity::Tolerance => "steering.tolerance_m",
        Quantity::TurnTolerance => "steering.turn_tolerance_rad",
        Quantity::TurnBeyond => "steering.turn_beyond_rad",
        Quantity::PositionVariance => "variance.position_m2",
        Quantity::HeadingVariance => "variance.heading_rad2",
        Quantity::LoopDelay => "loop_delay_s",
        Quantity::Watchdog => "watchdog_s",
        Quantity::Slots => "horizon_slots",
        Quantity::Lag => "drive.lag_s",
        Quantity::DeadTime => "drive.dead_time_s",
    }
}

impl Spec {
    /// The prior that is meant; anything where it is wrong, which `check` then knows.
    fn resolve_prior(
        &self,
        known: impl Fn(&str) -> Known<settings::Prior>,
        check: &mut Check,
    ) -> settings::Prior {
        let found = match &self.prior {
            PriorChoice::Inline(prior) => check.ok("prior", prior.convert()),
            PriorChoice::Named(name) => check.known("prior", name, reason::UNKNOWN_PRIOR, known),
        };
        found.unwrap_or_default()
    }

    /// The settings that this means, beginning with `prior`, whatever its values: what a program keeps was checked when
    /// it came.
    pub fn convert(&self, prior: settings::Prior) -> Settings {
        Settings {
            drive: self.drive.convert(),
            identifies_lag: false,
            identifies_dead_band: false,
            noise: self.noise.convert(),
            identifies_noise: false,
            method: self.method.into(),
            prior,
            attribution: self.attribution.into(),
            drift: self.drift,
            slots: self.horizon_slots,
            slot: SLOT,
            loop_delay: self.loop_delay_s,
            follows_link: settings::FollowsLink::default(),
            sensor_delay: self.sensor_delay_s,
            watchdog: self.watchdog_s,
            predictor: self.predictor.convert(),
            variance: settings::VarianceLimits {
                position: self.variance.position_m2,
                heading: self.variance.heading_rad2,
            },
            steering: settings::SteeringSettings {
                alpha: self.steering.alpha_m_per_s,
                stop_radius: self.steering.stop_radius_m,
                tolerance: self.steering.tolerance_m,
                turn_tolerance: self.steering.turn_tolerance_rad,
                turn_beyond: self.steering.turn_beyond_rad,
            },
        }
    }

    /// What one would say to have a robot of these settings whose prior goes by this name, if it has one.
    pub fn from_core(core: &Settings, prior: Option<&str>) -> Self {
        let spec = Self::from(core);
        Self { prior: prior.map_or(spec.prior, |it| PriorChoice::Named(it.to_owned())), ..spec }
    }
}

impl From<exchange::Observation> for Pose {
    fn from(core: exchange::Observation) -> Self {
        Self {
            x_m: core.pose.x,
            y_m: core.pose.y,
            heading_rad: core.pose.heading.radians(),
            taken_s: core.taken.seconds(),
        }
    }
}
