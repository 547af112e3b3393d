//! How fast to go in one slot so that the motion comes to exactly its length.

use crate::geometry::elementary::{least, most};

/// Halvings by which the speed is found: to the last digit of a float.
const HALVINGS: u32 = 52;

/// Most slots that are looked ahead: a minute of braking. What brakes longer stops short or late, and is seen to.
const MOST_SLOTS: u32 = 2000;

/// What differs by less than this many m or rad is the same length.
const SAME: f64 = 1e-10;

/// What binds a speed, in m and s or rad and s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Largest speed.
    pub fastest: f64,
    /// Below this speed the acceleration limit does not bind.
    pub least: f64,
    /// Largest change of speed per s.
    pub acceleration: f64,
    /// Length of a slot in s.
    pub slot: f64,
    /// The same of the acceleration that the first slot may use.
    pub first: f64,
}

/// The speed of the next slot where `remaining` is still to go, the speed so far is `previous`, and the robot is then to
/// rest: in as few slots as can be, within the limits, the last one as fast as the others allow.
///
/// The profile of N slots at w at most is v_k = min(w, up_k, down_k): up_k as fast as the acceleration allows from
/// `previous`, down_k so that it allows zero after slot N. N is the least number whose profile at the largest speed comes
/// to `remaining`, w the speed at which it comes to exactly that. Another slot of the same plan finds the same N and w; one
/// that begins at another time finds those that still come to the end.
pub fn pace(limits: &Limits, previous: f64, remaining: f64) -> f64 {
    let Limits { fastest, slot, .. } = *limits;
    if remaining <= 0.0 {
        return 0.0;
    }
    let suffice = |slots| distance(limits, previous, fastest, slots) >= remaining - SAME;
    // All of these slots at the largest speed are too few or just enough.
    let mut few = (remaining / (most(fastest, previous) * slot)) as u32;
    let braking = (fastest - limits.least).max(0.0) / (limits.acceleration * slot);
    if few >= MOST_SLOTS || f64::from(few) > 2.0 * braking + 4.0 {
        return fastest;
    }
    let mut many = few + 1;
    while !suffice(many) {
        few = many;
        many *= 2;
        if many > MOST_SLOTS {
            return fastest;
        }
    }
    while many - few > 1 {
        let middle = few.midpoint(many);
        if suffice(middle) { many = middle } else { few = middle }
    }
    let (mut low, mut high) = (0.0, fastest);
    for _ in 0..HALVINGS {
        let middle = f64::midpoint(low, high);
        if distance(limits, previous, middle, many) < remaining {
            low = middle
        } else {
            high = middle
        }
    }
    speed(limits, previous, high, many, 1)
}

/// The speed of slot `k` of a profile of `slots` at `top` at most.
fn speed(limits: &Limits, previous: f64, top: f64, slots: u32, k: u32) -> f64 {
    let Limits { least: free, acceleration, slot, first, .. } = *limits;
    let beyond = most(0.0, previous - free);
    let change = acceleration * (first + f64::from(k - 1) * slot);
    let up = free + beyond + change;
    let down = free + acceleration * slot * f64::from(slots + 1 - k);
    let lowest = if beyond > change { free + beyond - change } else { 0.0 };
    most(least(top, least(up, down)), lowest)
}

/// How far the profile comes.
fn distance(limits: &Limits, previous: f64, top: f64, slots: u32) -> f64 {
    (1..=slots).map(|k| speed(limits, previous, top, slots, k)).sum::<f64>() * limits.slot
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Twist;
    use crate::kinematics::Drive;
    use proptest::prelude::*;

    fn limits(drive: &Drive, fastest: f64) -> Limits {
        Limits {
            fastest,
            least: drive.min_linear,
            acceleration: drive.max_linear_acceleration,
            slot: 0.03,
            first: 0.03,
        }
    }

    /// Drives `length` with plans that begin anew after so many parts of a slot; the speeds of each piece and its time.
    fn driven(drive: &Drive, limits: Limits, length: f64, parts: &[f64]) -> Vec<(f64, f64)> {
        let (mut pieces, mut done, mut speed, mut change) = (vec![], 0.0, 0.0, 0.03);
        let mut parts = parts.iter().cycle();
        while length - done > 1e-9 {
            let wanted = pace(&Limits { first: change, ..limits }, speed, length - done);
            let (from, to) = (Twist::new(speed, 0.0), Twist::new(wanted, 0.0));
            speed = drive.reach(from, to, change).linear;
            let time = 0.03 * parts.next().unwrap();
            pieces.push((speed, time));
            done += speed * time;
            change = time;
            assert!(pieces.len() < 100_000);
        }
        pieces
    }

    proptest! {
        #[test]
        fn what_is_commanded_comes_to_exactly_the_length(length in 0.002..3.0f64, fastest in 0.03..0.13f64) {
            let drive = Drive::default();
            let pieces = driven(&drive, limits(&drive, fastest), length, &[1.0]);
            let sum: f64 = pieces.iter().map(|(speed, time)| speed * time).sum();
            prop_assert!((sum - length).abs() < 1e-9, "{sum}");
            let speeds = || pieces.iter().map(|(speed, _)| *speed);
            prop_assert!(speeds().all(|speed| speed <= fastest + 1e-12));
            let ends = speeds().skip(1).chain([0.0]);
            for (from, to) in speeds().zip(ends) {
                let change = drive.change_time(Twist::new(from, 0.0), Twist::new(to, 0.0));
                prop_assert!(change <= 0.03 + 1e-9, "{from} {to}");
            }
            // Slower than motors turn only where there is too little room for it.
            if length > 0.02 {
                prop_assert!(speeds().all(|speed| speed >= drive.min_linear - 1e-9));
            }
        }

        /// Guards against: plans that begin within a slot of the one before, at every pose.
        #[test]
        fn plans_that_begin_at_other_times_come_to_the_same(length in 0.1..2.0f64, part in 0.1..1.0f64) {
            let drive = Drive::default();
            let pieces = driven(&drive, limits(&drive, 0.09), length, &[1.0, 1.0, 1.0, part]);
            let sum: f64 = pieces.iter().map(|(speed, time)| speed * time).sum();
            prop_assert!((sum - length).abs() < 1e-3, "{sum}");
        }
    }

    #[test]
    fn a_robot_that_brakes_for_seconds_is_planned_in_time() {
        let limits =
            Limits { fastest: 2.0, least: 0.05, acceleration: 0.3, slot: 0.03, first: 0.03 };
        let (mut speed, mut done) = (0.0, 0.0);
        while 4.0 - done > 1e-9 {
            speed = pace(&limits, speed, 4.0 - done);
            done += speed * 0.03;
        }
        assert!((done - 4.0).abs() < 1e-9 && speed < 0.06);
    }
}
