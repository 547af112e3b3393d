//! What was seen and what to do about it, in words and numbers.

use super::finding::{Clock, Finding, Mirror, Quarter};

impl Finding {
    /// What was seen.
    pub fn seen(&self) -> String {
        match *self {
            Self::NoPoses { silence, poses: 0 } => format!("no pose came within {silence:.1} s"),
            Self::NoPoses { silence, poses } => {
                format!("no pose came for {silence:.1} s, after {poses} poses")
            }
            Self::TooFewPoses(rate) => format!("{rate:.1} poses a second"),
            Self::OtherClock(clock) => clock.seen(),
            Self::TooFar { distance, allowed } => format!(
                "the robot was seen {distance:.2} m from where it began; the check ended at {allowed:.2} m"
            ),
            Self::DoesNotMove { same: true, .. } => {
                "all poses were the same to the last digit while motion was commanded".to_owned()
            }
            Self::DoesNotMove { seen: (driven, turned), .. } => format!(
                "{:.0} % of the drives and {:.0} % of the turns commanded were seen",
                100.0 * driven,
                100.0 * turned
            ),
            Self::DoesNotDrive(part) => {
                format!("it turns; of the drives commanded {:.0} % were seen", 100.0 * part)
            }
            Self::DoesNotTurn(part) => {
                format!("it drives; of the turns commanded {:.0} % were seen", 100.0 * part)
            }
            Self::HeadingFixed(angle) => format!(
                "it drove in directions {angle:.1} rad apart while its heading stayed the same"
            ),
            Self::Units { times, .. } => {
                format!("positions changed by {times:.0} times what was commanded")
            }
            Self::Degrees { times, spread } => format!(
                "the heading changed by {times:.0} times what was commanded, and spreads by {spread:.2} at rest"
            ),
            Self::Inverted { left, wheels } => format!(
                "it spins where it should drive: the {} wheel runs backward ({})",
                side(left),
                parts(wheels)
            ),
            Self::BothInverted => {
                "it drives and turns the other way: both wheels are inverted, or the heading is half a turn off and an axis mirrored".to_owned()
            }
            Self::Swapped => {
                "it turns the other way and drives the right way: left and right wheel are swapped, or one axis of positions and heading is mirrored".to_owned()
            }
            Self::Stands { left, wheels } => {
                format!("it turns about its {} wheel, which stands ({})", side(left), parts(wheels))
            }
            Self::HalfTurn => {
                "it drives backward and turns the right way: the heading is half a turn off, or both wheels are inverted and swapped".to_owned()
            }
            Self::QuarterTurn(Quarter::Left) => {
                "the heading is a quarter of a turn off, too far to the left".to_owned()
            }
            Self::QuarterTurn(Quarter::Right) => {
                "the heading is a quarter of a turn off, too far to the right".to_owned()
            }
            Self::HeadingOff(off) => {
                format!("the heading is off by {off:+.2} rad, counter-clockwise")
            }
            Self::Clockwise(zero) => format!(
                "positions are right and the heading counts clockwise, from {zero:+.1} rad off the x axis"
            ),
            Self::Mirrored(mirror) => mirror.seen().to_owned(),
            Self::Delay { seen, described } => format!(
                "motion is seen {seen:.2} s after its command, lag and dead time are described as {described:.2} s"
            ),
            Self::Noise { seen, described } => format!(
                "poses at rest spread by {:.1} mm and {:.4} rad, described are {:.1} mm and {:.4} rad",
                1000.0 * seen.position,
                seen.heading,
                1000.0 * described.position,
                described.heading
            ),
            Self::WheelRadius { as_with, described } => format!(
                "it moves as with a wheel radius of {as_with:.4} m, {described:.4} m are described"
            ),
            Self::TrackWidth { as_with, described } => format!(
                "it turns as with a track width of {as_with:.4} m, {described:.4} m are described"
            ),
            Self::Unclear => {
                "drives and turns fit no single mistake of frame, units or wheels".to_owned()
            }
        }
    }

    /// What to do about it.
    pub fn remedy(&self) -> &'static str {
        match *self {
            Self::NoPoses { poses: 0, .. } => {
                "see the agent's log: check that the tracker sees the robot, that poses reach the agent, and that their stamps are of the agent's own monotonic clock (or leave the stamps out)"
            }
            Self::NoPoses { .. } => {
                "keep the robot where the tracker sees it, and check the way from the tracker to the agent"
            }
            Self::TooFewPoses(_) => "have the tracker send 10 poses a second or more",
            Self::OtherClock(_) => {
                "stamp poses with the monotonic clock of the agent's own host (Python: time.monotonic()) when they are taken, or leave the stamps out"
            }
            Self::TooFar { .. } => {
                "lift the robot off the floor and see whether its wheels stop when told; then check drive.wheel_radius_m and that nobody moved it"
            }
            Self::DoesNotMove { same: true, .. } => {
                "if the robot moved, the tracker repeats its last pose; if it stood, check power, emergency stop, motor drivers and that the agent's wheel speeds reach them"
            }
            Self::DoesNotMove { .. } => {
                "check power, emergency stop, motor drivers and that the agent's wheel speeds reach them; free the wheels"
            }
            Self::DoesNotDrive(_) => {
                "describe drive.min_linear_m_per_s, the least speed at which it drives; check that positions come from this robot"
            }
            Self::DoesNotTurn(_) => {
                "describe drive.min_angular_rad_per_s, the least speed at which it turns in place; check that the heading comes from this robot"
            }
            Self::HeadingFixed(_) => {
                "have the tracker send the heading of the robot, counter-clockwise from x in rad"
            }
            Self::Units { millimetres: true, .. } => "divide x and y by 1000: positions are in m",
            Self::Units { millimetres: false, .. } => "divide x and y by 100: positions are in m",
            Self::Degrees { .. } => {
                "multiply the heading by pi/180: it is in rad; then check again"
            }
            Self::Inverted { left: true, .. } => "invert the left motor; then check again",
            Self::Inverted { left: false, .. } => "invert the right motor; then check again",
            Self::BothInverted => {
                "invert both motors; or, if wheels turn forward when told to, check the tracker's axes and add pi to its heading"
            }
            Self::Swapped => {
                "swap the plugs of the motors; or, if the left wheel is the left one, make the tracker's frame right-handed (x forward, y left, heading counter-clockwise)"
            }
            Self::Stands { left: true, .. } => "check the left wheel's motor, driver and plug",
            Self::Stands { left: false, .. } => "check the right wheel's motor, driver and plug",
            Self::HalfTurn => {
                "add pi to the heading that the tracker sends; or, if wheels turn backward when told forward, invert both motors and swap their plugs"
            }
            Self::QuarterTurn(Quarter::Left) => {
                "subtract pi/2 from the heading that the tracker sends"
            }
            Self::QuarterTurn(Quarter::Right) => "add pi/2 to the heading that the tracker sends",
            Self::HeadingOff(_) => {
                "subtract that from the heading that the tracker sends: it is to point where the robot drives"
            }
            Self::Clockwise(_) => {
                "change the sign of the heading, and count it from x: 0 along x, pi/2 along y"
            }
            Self::Mirrored(mirror) => mirror.remedy(),
            Self::Delay { seen, described } if seen > described => {
                "stamp poses when they are taken; what is left is the drive's: describe drive.dead_time_s (--dead-time), or drive.lag_s (--lag) where it starts slowly"
            }
            Self::Delay { .. } => "describe a smaller drive.dead_time_s or drive.lag_s",
            Self::Noise { .. } => {
                "describe it: noise.position_m, noise.heading_rad (--position-noise, --heading-noise); or give the tracker more light and a larger marker"
            }
            Self::WheelRadius { .. } => {
                "measure the wheels and describe drive.wheel_radius_m (--wheel-radius); check the scale of the tracker and the gear of the wheel speeds"
            }
            Self::TrackWidth { .. } => {
                "describe drive.track_width_m (--track-width) so: a skid-steered robot turns as with a larger one than it has"
            }
            Self::Unclear => {
                "check that the tracker follows this robot alone and that nothing held or moved it, then check again"
            }
        }
    }
}

impl Clock {
    fn seen(self) -> String {
        match self {
            Self::Old(age) => format!("no pose was younger than {age:.2} s when it was sent"),
            Self::Future(by) => format!("poses are stamped {by:.2} s after they were sent"),
            Self::Before(by) => format!("motion is seen {by:.2} s before its command"),
            Self::Drifts(by) => {
                format!(
                    "the stamps drift against the agent's clock, by {by:+.2} s within the check"
                )
            }
        }
    }
}

impl Mirror {
    fn seen(self) -> &'static str {
        match self {
            Self::X => "positions are mirrored in x, the heading is not",
            Self::Y => "positions are mirrored in y, the heading is not",
            Self::Exchanged => "positions have x and y exchanged, the heading has not",
            Self::ExchangedBack => {
                "positions have x and y exchanged and both the other way, the heading has not"
            }
        }
    }

    fn remedy(self) -> &'static str {
        match self {
            Self::X => "change the sign of x of the tracker's positions",
            Self::Y => "change the sign of y of the tracker's positions",
            Self::Exchanged => "exchange x and y of the tracker's positions",
            Self::ExchangedBack => {
                "exchange x and y of the tracker's positions and change the sign of both"
            }
        }
    }
}

fn side(left: bool) -> &'static str {
    if left { "left" } else { "right" }
}

fn parts((left, right): (f64, f64)) -> String {
    format!("left {:+.0} %, right {:+.0} % of the command", 100.0 * left, 100.0 * right)
}
