//! What a check finds, with its numbers.

use crate::exchange::PoseNoise;
use arrayvec::ArrayVec;

/// Most findings of one check; there are not so many that go together.
pub const MOST: usize = 8;

/// What a check finds, the gravest first.
pub type Findings = ArrayVec<Finding, MOST>;

/// What is wrong with the positions where the heading is right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mirror {
    /// x points the other way.
    X,
    /// y points the other way.
    Y,
    /// x and y are exchanged.
    Exchanged,
    /// x and y are exchanged and both point the other way.
    ExchangedBack,
}

/// Which way the heading is a quarter of a turn off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quarter {
    /// Too far to the left.
    Left,
    /// Too far to the right.
    Right,
}

/// The name of what is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Fault {
    /// No poses come, or no more of them.
    NoPoses,
    /// Too few poses a second to see the motions.
    TooFewPoses,
    /// The stamps of the poses are of another clock.
    OtherClock,
    /// The robot was seen farther away than it can be on its own wheels.
    TooFar,
    /// Nothing moves.
    DoesNotMove,
    /// It turns and does not drive.
    DoesNotDrive,
    /// It drives and does not turn.
    DoesNotTurn,
    /// It turns, and the heading stays the same.
    HeadingFixed,
    /// Positions are in millimetres.
    Millimetres,
    /// Positions are in centimetres.
    Centimetres,
    /// The heading is in degrees.
    Degrees,
    /// The left wheel runs backward.
    LeftInverted,
    /// The right wheel runs backward.
    RightInverted,
    /// Both wheels run backward, or the heading is half a turn off and an axis mirrored.
    BothInverted,
    /// The wheels are swapped, or an axis of positions and heading is mirrored.
    Swapped,
    /// The left wheel does not turn.
    LeftStands,
    /// The right wheel does not turn.
    RightStands,
    /// The heading is half a turn off, or the robot is described back to front.
    HalfTurn,
    /// The heading is a quarter of a turn off.
    QuarterTurn,
    /// The heading is off by something else.
    HeadingOff,
    /// The heading counts clockwise.
    Clockwise,
    /// Positions are mirrored in x, their heading is not.
    MirroredX,
    /// Positions are mirrored in y, their heading is not.
    MirroredY,
    /// Positions have x and y exchanged, their heading has not.
    Exchanged,
    /// Motion comes later after its command than described, or sooner.
    Delay,
    /// The poses are noisier than described.
    Noise,
    /// It moves as with wheels of another radius.
    WheelRadius,
    /// It turns as with another track width.
    TrackWidth,
    /// The motions fit nothing of all this.
    Unclear,
}

impl Fault {
    /// All of them, in the order in which they are documented.
    pub const ALL: [Self; 29] = [
        Self::NoPoses,
        Self::TooFewPoses,
        Self::OtherClock,
        Self::TooFar,
        Self::DoesNotMove,
        Self::DoesNotDrive,
        Self::DoesNotTurn,
        Self::HeadingFixed,
        Self::Millimetres,
        Self::Centimetres,
        Self::Degrees,
        Self::LeftInverted,
        Self::RightInverted,
        Self::BothInverted,
        Self::Swapped,
        Self::LeftStands,
        Self::RightStands,
        Self::HalfTurn,
        Self::QuarterTurn,
        Self::HeadingOff,
        Self::Clockwise,
        Self::MirroredX,
        Self::MirroredY,
        Self::Exchanged,
        Self::Delay,
        Self::Noise,
        Self::WheelRadius,
        Self::TrackWidth,
        Self::Unclear,
    ];

    /// The name used on the wire.
    pub fn name(self) -> &'static str {
        match self {
            Self::NoPoses => "no-poses",
            Self::TooFewPoses => "too-few-poses",
            Self::OtherClock => "other-clock",
            Self::TooFar => "too-far",
            Self::DoesNotMove => "does-not-move",
            Self::DoesNotDrive => "does-not-drive",
            Self::DoesNotTurn => "does-not-turn",
            Self::HeadingFixed => "heading-fixed",
            Self::Millimetres => "positions-in-millimetres",
            Self::Centimetres => "positions-in-centimetres",
            Self::Degrees => "heading-in-degrees",
            Self::LeftInverted => "left-wheel-inverted",
            Self::RightInverted => "right-wheel-inverted",
            Self::BothInverted => "both-wheels-inverted",
            Self::Swapped => "wheels-swapped",
            Self::LeftStands => "left-wheel-stands",
            Self::RightStands => "right-wheel-stands",
            Self::HalfTurn => "heading-half-turn-off",
            Self::QuarterTurn => "heading-quarter-turn-off",
            Self::HeadingOff => "heading-off",
            Self::Clockwise => "heading-clockwise",
            Self::MirroredX => "x-mirrored",
            Self::MirroredY => "y-mirrored",
            Self::Exchanged => "axes-exchanged",
            Self::Delay => "delay",
            Self::Noise => "noise",
            Self::WheelRadius => "wheel-radius",
            Self::TrackWidth => "track-width",
            Self::Unclear => "unclear",
        }
    }
}

/// Something wrong, with its numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Finding {
    /// See [`Fault::NoPoses`].
    NoPoses {
        /// Time in s without a pose.
        silence: f64,
        /// Poses before it.
        poses: u32,
    },
    /// See [`Fault::TooFewPoses`]: so many a second.
    TooFewPoses(f64),
    /// See [`Fault::OtherClock`].
    OtherClock(Clock),
    /// See [`Fault::TooFar`].
    TooFar {
        /// Distance in m from the beginning.
        distance: f64,
        /// Largest distance allowed in m.
        allowed: f64,
    },
    /// See [`Fault::DoesNotMove`].
    DoesNotMove {
        /// Whether all poses were the same, bit for bit.
        same: bool,
        /// Part of the commanded drives and turns that was seen.
        seen: (f64, f64),
    },
    /// See [`Fault::DoesNotDrive`]: the part of the commanded drives that was seen.
    DoesNotDrive(f64),
    /// See [`Fault::DoesNotTurn`]: the part of the commanded turns that was seen.
    DoesNotTurn(f64),
    /// See [`Fault::HeadingFixed`]: the angle in rad between drives, which the heading does not show.
    HeadingFixed(f64),
    /// See [`Fault::Millimetres`] and [`Fault::Centimetres`].
    Units {
        /// Whether they are millimetres.
        millimetres: bool,
        /// Times what was commanded.
        times: f64,
    },
    /// See [`Fault::Degrees`].
    Degrees {
        /// Times the turn commanded.
        times: f64,
        /// Spread at rest in what the heading is in.
        spread: f64,
    },
    /// One wheel runs backward.
    Inverted {
        /// Whether it is the left one.
        left: bool,
        /// What left and right wheel make of their commands.
        wheels: (f64, f64),
    },
    /// See [`Fault::BothInverted`].
    BothInverted,
    /// See [`Fault::Swapped`].
    Swapped,
    /// One wheel does not turn.
    Stands {
        /// Whether it is the left one.
        left: bool,
        /// What left and right wheel make of their commands.
        wheels: (f64, f64),
    },
    /// See [`Fault::HalfTurn`].
    HalfTurn,
    /// See [`Fault::QuarterTurn`].
    QuarterTurn(Quarter),
    /// See [`Fault::HeadingOff`]: by so many rad, to the left where positive.
    HeadingOff(f64),
    /// See [`Fault::Clockwise`]: the direction in rad, counter-clockwise from x, in which it is 0.
    Clockwise(f64),
    /// The positions are mirrored or their axes exchanged.
    Mirrored(Mirror),
    /// See [`Fault::Delay`].
    Delay {
        /// Time in s from command to motion.
        seen: f64,
        /// The same as described.
        described: f64,
    },
    /// See [`Fault::Noise`].
    Noise {
        /// What was seen at rest.
        seen: PoseNoise,
        /// What is described.
        described: PoseNoise,
    },
    /// See [`Fault::WheelRadius`].
    WheelRadius {
        /// The radius in m that explains the motion.
        as_with: f64,
        /// The one described.
        described: f64,
    },
    /// See [`Fault::TrackWidth`].
    TrackWidth {
        /// The width in m that explains the turns.
        as_with: f64,
        /// The one described.
        described: f64,
    },
    /// See [`Fault::Unclear`].
    Unclear,
}

/// How stamps show that they are of another clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Clock {
    /// No pose was younger than so many s when it was sent.
    Old(f64),
    /// Poses were taken so many s after they were sent.
    Future(f64),
    /// Motion was seen so many s before its command.
    Before(f64),
    /// The poses grew older by so many s within the check.
    Drifts(f64),
}

impl Finding {
    /// Its name.
    pub fn fault(&self) -> Fault {
        match *self {
            Self::NoPoses { .. } => Fault::NoPoses,
            Self::TooFewPoses(_) => Fault::TooFewPoses,
            Self::OtherClock(_) => Fault::OtherClock,
            Self::TooFar { .. } => Fault::TooFar,
            Self::DoesNotMove { .. } => Fault::DoesNotMove,
            Self::DoesNotDrive(_) => Fault::DoesNotDrive,
            Self::DoesNotTurn(_) => Fault::DoesNotTurn,
            Self::HeadingFixed(_) => Fault::HeadingFixed,
            Self::Units { millimetres: true, .. } => Fault::Millimetres,
            Self::Units { millimetres: false, .. } => Fault::Centimetres,
            Self::Degrees { .. } => Fault::Degrees,
            Self::Inverted { left: true, .. } => Fault::LeftInverted,
            Self::Inverted { left: false, .. } => Fault::RightInverted,
            Self::BothInverted => Fault::BothInverted,
            Self::Swapped => Fault::Swapped,
            Self::Stands { left: true, .. } => Fault::LeftStands,
            Self::Stands { left: false, .. } => Fault::RightStands,
            Self::HalfTurn => Fault::HalfTurn,
            Self::QuarterTurn(_) => Fault::QuarterTurn,
            Self::HeadingOff(_) => Fault::HeadingOff,
            Self::Clockwise(_) => Fault::Clockwise,
            Self::Mirrored(Mirror::X) => Fault::MirroredX,
            Self::Mirrored(Mirror::Y) => Fault::MirroredY,
            Self::Mirrored(Mirror::Exchanged | Mirror::ExchangedBack) => Fault::Exchanged,
            Self::Delay { .. } => Fault::Delay,
            Self::Noise { .. } => Fault::Noise,
            Self::WheelRadius { .. } => Fault::WheelRadius,
            Self::TrackWidth { .. } => Fault::TrackWidth,
            Self::Unclear => Fault::Unclear,
        }
    }
}
