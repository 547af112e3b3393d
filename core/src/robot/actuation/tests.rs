use super::*;
use crate::horizon::{MAX_DURATION, MAX_SLOTS, MAX_WATCHDOG};
use proptest::prelude::*;

fn horizon(sequence: u64, start: f64, speeds: &[f64]) -> Horizon {
    let drive = Drive::default();
    Horizon {
        sequence,
        answers: sequence,
        start: RobotTime::new(start),
        slot: SLOT,
        watchdog: 0.3,
        speeds: speeds.iter().map(|&v| kinematics::inverse(&drive, Twist::new(v, 0.0))).collect(),
    }
}

fn linear(actuation: &mut Actuation, now: f64) -> f64 {
    actuation.advance(RobotTime::new(now));
    actuation.output().linear
}

#[test]
fn a_horizon_waits_for_its_start() {
    let mut actuation = Actuation::new(Drive::default(), RobotTime::ZERO);
    actuation.accept(&horizon(1, 1.0, &[0.02]));
    assert_eq!(linear(&mut actuation, 0.5), 0.0);
    assert_eq!(actuation.playing(), None);
    assert_eq!(actuation.next_change(), RobotTime::new(1.0));
    assert!((linear(&mut actuation, 1.0) - 0.02).abs() < 1e-12);
    assert_eq!(actuation.playing(), Some(Playing { horizon: 1, since: RobotTime::new(1.0) }));
}

#[test]
fn newest_wins_whatever_the_order() {
    let mut actuation = Actuation::new(Drive::default(), RobotTime::ZERO);
    assert_eq!(actuation.accept(&horizon(5, 0.1, &[0.02; 9])), Acceptance::Newest);
    assert_eq!(actuation.accept(&horizon(4, 0.1, &[0.01; 9])), Acceptance::Stale);
    assert_eq!(actuation.accept(&horizon(5, 0.1, &[0.01; 9])), Acceptance::Stale);
    assert!((linear(&mut actuation, 0.2) - 0.02).abs() < 1e-12);
}

#[test]
fn the_old_horizon_plays_until_the_new_one_begins() {
    let mut actuation = Actuation::new(Drive::default(), RobotTime::ZERO);
    actuation.accept(&horizon(1, 0.0, &[0.01; 20]));
    actuation.advance(RobotTime::new(0.0));
    actuation.accept(&horizon(2, 0.1, &[0.02; 20]));
    assert!((linear(&mut actuation, 0.09) - 0.01).abs() < 1e-12);
    assert!((linear(&mut actuation, 0.10) - 0.02).abs() < 1e-12);
}

#[test]
fn a_single_slot_that_comes_late_plays_on_arrival_until_it_expires() {
    let mut actuation = Actuation::new(Drive::default(), RobotTime::ZERO);
    actuation.advance(RobotTime::new(1.2));
    actuation.accept(&horizon(1, 1.0, &[0.02]));
    assert!((linear(&mut actuation, 1.2) - 0.02).abs() < 1e-12);
    assert_eq!(linear(&mut actuation, 1.5), 0.0);
    let mut late = Actuation::new(Drive::default(), RobotTime::ZERO);
    late.accept(&horizon(1, 1.0, &[0.02]));
    assert_eq!(linear(&mut late, 1.4), 0.0);
}

#[test]
fn a_stop_on_the_robot_needs_no_link() {
    let mut actuation = Actuation::new(Drive::default(), RobotTime::ZERO);
    actuation.accept(&horizon(1, 0.0, &[0.02; 20]));
    actuation.advance(RobotTime::new(0.1));
    actuation.stop();
    actuation.advance(RobotTime::new(0.11));
    assert!(actuation.is_at_rest());
}

/// A plan that uses the limit to the full passes unchanged; a jump is spread within the limit.
#[test]
fn plans_pass_and_jumps_are_spread() {
    let drive = Drive::default();
    let step = drive.max_linear_acceleration * SLOT;
    let plan: Vec<f64> = (0..10).map(|i| 0.023 + step * f64::from(i)).collect();
    let mut actuation = Actuation::new(drive, RobotTime::ZERO);
    actuation.accept(&horizon(1, 0.0, &plan));
    for (i, &v) in plan.iter().enumerate() {
        let now = i as f64 * SLOT;
        assert!((linear(&mut actuation, now) - v).abs() < 1e-9, "slot {i}");
    }
    let mut jump = Actuation::new(drive, RobotTime::ZERO);
    jump.accept(&horizon(1, 0.0, &[0.13; 60]));
    let (mut now, mut before) = (0.0, 0.0);
    while before < 0.13 - 1e-9 {
        let v = linear(&mut jump, now);
        let allowed = step + drive.min_linear;
        assert!(v - before <= allowed + 1e-9);
        assert!(v <= drive.min_linear + drive.max_linear_acceleration * (now + SLOT) + 1e-9);
        before = v;
        now = jump.next_change().seconds();
        assert!(now < 1.0);
    }
}

/// Guards against: poses without delay, so that more horizons wait than are held, and none ever begins.
#[test]
fn however_early_replies_come_each_slot_plays_a_newer_horizon() {
    for lead in [0.01, 0.23, 1.0, 2.0] {
        let mut actuation = Actuation::new(Drive::default(), RobotTime::ZERO);
        let mut played = 0;
        for slot in 0..200_u64 {
            let now = slot as f64 * SLOT;
            actuation.accept(&horizon(slot + 1, now + lead, &[0.02; 20]));
            actuation.advance(RobotTime::new(now));
            let playing = actuation.playing().map_or(0, |playing| playing.horizon);
            assert!(playing >= played, "lead {lead}");
            played = playing;
        }
        let newest_begun = 200 - (lead / SLOT) as u64;
        // A horizon of twenty slots bridges what was thinned out.
        assert!(played + 10 >= newest_begun, "lead {lead}: {played}");
    }
}

/// A ramp to rest takes the time that the limit asks for, down to the smallest speed too.
#[test]
fn a_stop_at_any_speed_keeps_the_limit() {
    let drive = Drive::default();
    let mut actuation = Actuation::new(drive, RobotTime::ZERO);
    actuation.accept(&horizon(1, 0.0, &[0.13; 60]));
    let mut now = 0.0;
    while actuation.output().linear < 0.13 {
        actuation.advance(RobotTime::new(now));
        now = actuation.next_change().seconds().min(now + SLOT);
    }
    now += SLOT;
    actuation.advance(RobotTime::new(now));
    actuation.stop();
    let (began, mut used) = (now, 0.0_f64);
    while !actuation.is_at_rest() {
        let before = actuation.output();
        now += RAMP_STEP;
        actuation.advance(RobotTime::new(now));
        used = (used - RAMP_STEP).max(0.0) + drive.change_time(before, actuation.output());
        assert!(used <= SLOT + 1e-5, "{used} s of change at {} s", now - began);
    }
    let limit = (0.13 - drive.min_linear) / drive.max_linear_acceleration;
    assert!(now - began >= limit - SLOT - 1e-9 && now - began <= limit + RAMP_STEP);
}

/// Whatever a server says once, a robot that then hears nothing more comes to rest in good time.
#[test]
fn no_single_horizon_drives_a_robot_for_long() {
    let drive = Drive::default();
    let longest = MAX_LEAD + MAX_DURATION + MAX_WATCHDOG + 0.13 / drive.max_linear_acceleration;
    for start in [-1e9, -3.0, 0.0, 2.0, 2.09, 2.1, 60.0, 1e9, f64::INFINITY, f64::NAN] {
        for slot in [1e-12, 0.001, SLOT, 1.0, 1e6, 1e300, 0.0, -1.0, f64::INFINITY, f64::NAN] {
            for watchdog in [0.05, 0.3, 5.0, 1e9, -1.0, f64::INFINITY, f64::NAN] {
                let mut actuation = Actuation::new(drive, RobotTime::ZERO);
                let sent = horizon(1, start, &[0.13; MAX_SLOTS]);
                actuation.accept(&Horizon { slot, watchdog, ..sent });
                let (mut now, mut moved) = (0.0, 0.0);
                while now < longest + 1.0 {
                    actuation.advance(RobotTime::new(now));
                    assert!(actuation.output().linear <= 0.13 + 1e-12);
                    if actuation.output() != Twist::ZERO {
                        moved = now;
                    }
                    now += RAMP_STEP;
                }
                let said =
                    format!("{moved} s with start {start}, slot {slot}, watchdog {watchdog}");
                assert!(moved <= longest + RAMP_STEP && actuation.is_at_rest(), "{said}");
            }
        }
    }
}

#[test]
fn what_is_not_believed_leaves_what_plays_as_it_is() {
    let mut actuation = Actuation::new(Drive::default(), RobotTime::ZERO);
    assert_eq!(actuation.accept(&horizon(1, 0.0, &[0.02; 20])), Acceptance::Newest);
    let far = horizon(2, 1000.0, &[0.13; 20]);
    assert_eq!(actuation.accept(&far), Acceptance::Unbelievable);
    let mut nonsense = horizon(3, 0.1, &[0.13; 20]);
    nonsense.speeds[7].left = f64::NAN;
    assert_eq!(actuation.accept(&nonsense), Acceptance::Unbelievable);
    assert!((linear(&mut actuation, 0.2) - 0.02).abs() < 1e-12);
    assert_eq!(actuation.accept(&horizon(2, 0.21, &[0.01; 20])), Acceptance::Newest);
    assert!((linear(&mut actuation, 0.3) - 0.01).abs() < 1e-12);
}

/// Advances to `until` with every change on the way; the largest speed from a slot after now on.
fn fastest(actuation: &mut Actuation, until: f64) -> f64 {
    let until = RobotTime::new(until);
    let (began, mut fastest) = (actuation.time, 0.0_f64);
    while actuation.time < until {
        let next = actuation.next_change().earlier(actuation.time + RAMP_STEP).earlier(until);
        actuation.advance(next);
        if next > began + SLOT {
            fastest = fastest.max(actuation.output().linear);
        }
    }
    fastest
}

/// A robot at full speed, one horizon later.
fn at_full_speed() -> Actuation {
    let mut actuation = Actuation::new(Drive::default(), RobotTime::ZERO);
    actuation.accept(&horizon(1, 0.0, &[0.13; 60]));
    fastest(&mut actuation, 0.6);
    assert_eq!(actuation.output().linear, 0.13);
    actuation
}

#[test]
fn a_hold_ramps_to_rest_at_once_and_nothing_planned_before_its_end_moves_the_robot() {
    let drive = Drive::default();
    let hold = LocalLimits { hold: true, max_speed: None };
    let mut actuation = at_full_speed();
    actuation.restrain(hold, 7);
    assert_eq!(actuation.playing(), None);
    let before = actuation.output();
    actuation.advance(RobotTime::new(0.601));
    assert!(actuation.output().linear < before.linear, "it acts at once");
    let stopping = drive.stopping_time(before);
    fastest(&mut actuation, 0.6 + stopping + SLOT);
    assert!(actuation.is_at_rest());
    assert_eq!(actuation.accept(&horizon(8, 1.2, &[0.13; 60])), Acceptance::Held);
    assert_eq!(fastest(&mut actuation, 2.0), 0.0);
    // Let go: what requests 8 to 11 asked for was planned for a robot that rests, or before the server knew of it.
    actuation.restrain(LocalLimits::NONE, 11);
    for sequence in [8, 11] {
        let planned = horizon(sequence, 2.0, &[0.13; 60]);
        assert_eq!(actuation.accept(&planned), Acceptance::Stale);
    }
    assert_eq!((fastest(&mut actuation, 2.2), actuation.playing()), (0.0, None));
    assert_eq!(actuation.accept(&horizon(12, 2.2, &[0.13; 60])), Acceptance::Newest);
    assert!(fastest(&mut actuation, 3.0) > 0.129);
}

#[test]
fn a_speed_that_the_robot_allows_is_kept_within_the_ramp() {
    let mut actuation = at_full_speed();
    actuation.restrain(LocalLimits { hold: false, max_speed: Some(0.05) }, 1);
    fastest(&mut actuation, 0.6 + 0.08 / 0.3 + SLOT);
    assert!((fastest(&mut actuation, 1.5) - 0.05).abs() < 1e-12);
    assert_eq!(actuation.playing().map(|playing| playing.horizon), Some(1));
    actuation.restrain(LocalLimits::NONE, 1);
    assert!((fastest(&mut actuation, 1.9) - 0.13).abs() < 1e-12);
}

proptest! {
    /// Whatever arrives in whatever order: speeds stay within those demanded, the newest sequence wins,
    /// and the robot stops by itself.
    #[test]
    fn any_traffic_ends_at_rest(arrivals in prop::collection::vec((0u64..20, 0.0..1.0f64, 0.0..0.13f64, 1usize..20), 1..40)) {
        let mut actuation = Actuation::new(Drive::default(), RobotTime::ZERO);
        let mut now = 0.0;
        for (sequence, start, v, slots) in arrivals {
            now += 0.02;
            actuation.accept(&horizon(sequence, start, &vec![v; slots]));
            prop_assert!(linear(&mut actuation, now) <= 0.13 + 1e-12);
        }
        let mut steps = 0;
        while !actuation.is_at_rest() {
            actuation.advance(actuation.next_change());
            steps += 1;
            prop_assert!(steps < 1000);
        }
        prop_assert!(actuation.time.seconds() < 1.0 + 20.0 * SLOT + 0.3 + 2.0);
    }
}
