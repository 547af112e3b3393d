use super::*;
use proptest::prelude::*;

fn t(seconds: f64) -> RobotTime {
    RobotTime::new(seconds)
}

/// Sends twenty slots of one speed.
fn send(commands: &mut Commands, sequence: u64, start: f64, speed: f64) {
    let horizon = commands.begin(sequence, t(start), SLOT, 0.3);
    horizon.speeds.extend([WheelSpeeds { left: speed, right: speed }; 20]);
}

fn three() -> Commands {
    let mut commands = Commands::default();
    for (sequence, start, speed) in [(1, 0.0, 1.0), (2, 0.1, 1.2), (3, 0.2, 1.4)] {
        send(&mut commands, sequence, start, speed);
    }
    commands
}

#[test]
fn as_sent_each_horizon_holds_until_the_next_begins() {
    let (commands, drive) = (three(), Drive::default());
    let at = |time| commands.at(Attribution::Sent, &drive, t(time)).left;
    assert_eq!([at(-0.1), at(0.05), at(0.1), at(0.25)], [0.0, 1.0, 1.2, 1.4]);
    assert_eq!(at(5.0), 0.0, "a robot that hears nothing stops by itself");
}

#[test]
fn as_played_the_reports_count() {
    let (mut commands, drive) = (three(), Drive::default());
    commands.report(Playing { horizon: 1, since: t(0.0) }, t(0.10));
    commands.report(Playing { horizon: 1, since: t(0.0) }, t(0.18));
    commands.report(Playing { horizon: 3, since: t(0.22) }, t(0.30));
    let at = |time| commands.at(Attribution::Played, &drive, t(time)).left;
    assert_eq!([at(0.05), at(0.15), at(0.21), at(0.25)], [1.0, 1.0, 1.0, 1.4]);
    assert!(commands.is_known(&drive, t(0.05), t(0.29)));
    assert!(!commands.is_known(&drive, t(0.05), t(0.31)), "nothing is known past the last report");
    assert!(!commands.is_known(&drive, t(-0.1), t(0.2)), "nor before the first");
}

#[test]
fn a_robot_that_rests_on_its_own_ramps_down_and_plays_nothing_later() {
    let (mut commands, drive) = (three(), Drive::default());
    for attribution in [Attribution::Sent, Attribution::Played] {
        commands.interrupt(4, attribution, &drive, t(0.15));
        let at = |time| commands.at(attribution, &drive, t(time)).left;
        assert_eq!([at(0.05), at(0.12), at(0.16)], [1.0, 1.2, 1.2]);
        // 0.036 m/s take 0.12 s
        assert!((0.1..1.1).contains(&at(0.21)), "{}", at(0.21));
        assert_eq!([at(0.31), at(1.0)], [0.0, 0.0]);
    }
}

#[test]
fn a_hole_in_the_reports_is_noticed() {
    let (mut commands, drive) = (three(), Drive::default());
    commands.report(Playing { horizon: 1, since: t(0.0) }, t(0.05));
    commands.report(Playing { horizon: 3, since: t(0.22) }, t(0.30));
    assert!(!commands.is_known(&drive, t(0.01), t(0.28)));
}

#[test]
fn a_jump_between_plans_is_not_known() {
    let (mut commands, drive) = (three(), Drive::default());
    send(&mut commands, 4, 0.3, 4.0);
    commands.report(Playing { horizon: 1, since: t(0.0) }, t(0.28));
    commands.report(Playing { horizon: 4, since: t(0.3) }, t(1.0));
    assert!(commands.is_known(&drive, t(0.05), t(0.25)));
    assert!(!commands.is_known(&drive, t(0.25), t(0.5)), "0.078 m/s more take 0.26 s");
    assert!(!commands.is_known(&drive, t(0.4), t(0.5)));
    assert!(commands.is_known(&drive, t(0.7), t(0.8)));
}

/// Long after the first horizons are forgotten, and with poses taken on the way, walks see what each moment sees.
#[test]
fn walks_begin_where_the_last_pose_was_taken_however_much_was_sent() {
    let (mut commands, drive) = (Commands::default(), Drive::default());
    for sequence in 0..250_u16 {
        let start = t(f64::from(sequence) * 2.5 * SLOT);
        let horizon = commands.begin(u64::from(sequence), start, SLOT, 0.3);
        let speeds = (0..20).map(|slot| f64::from(sequence) + 0.01 * f64::from(slot));
        horizon.speeds.extend(speeds.map(|speed| WheelSpeeds { left: speed, right: speed }));
        if sequence % 3 == 0 {
            commands.settle(start - 7.0 * SLOT);
        }
        // From where the pose was taken, from later, and from before what has settled.
        for back in [7.0, 3.0, 12.0] {
            let (mut time, mut wrong) = (start - back * SLOT, 0);
            commands.walk(Attribution::Sent, &drive, time, start + 4.0 * SLOT, |speeds, held| {
                let then = time + held / 2.0;
                wrong += i32::from(speeds != commands.at(Attribution::Sent, &drive, then));
                time += held;
            });
            assert_eq!(wrong, 0, "horizon {sequence}, {back} slots back");
            assert!((time - start - 4.0 * SLOT).abs() < 1e-9);
        }
    }
}

proptest! {
    /// A walk covers its time exactly and sees what looking at each moment sees.
    #[test]
    fn a_walk_has_no_gap(from in -0.2..0.5f64, length in 0.0..2.0f64, played in any::<bool>()) {
        let (mut commands, drive) = (three(), Drive::default());
        commands.report(Playing { horizon: 1, since: t(0.03) }, t(0.10));
        commands.report(Playing { horizon: 2, since: t(0.13) }, t(0.20));
        let attribution = if played { Attribution::Played } else { Attribution::Sent };
        let from = t(from);
        let mut time = from;
        let mut wrong = 0;
        commands.walk(attribution, &drive, from, from + length, |speeds, duration| {
            wrong += i32::from(speeds != commands.at(attribution, &drive, time + duration / 2.0));
            time += duration;
        });
        prop_assert_eq!(wrong, 0);
        prop_assert!((time - from - length).abs() < 1e-6);
    }

    /// Guards against: a walk without an end, where a clock is so large that a boundary rounds to a moment that is
    /// not later. Clocks over the whole range of the contract, pauses from a microsecond to a day, ramps of hours.
    #[test]
    fn a_walk_ends_and_covers_its_time_whatever_the_clock_reads(
        base in -1e9..1e9f64, first in 1usize..100, slots in 1usize..=MAX_SLOTS, back in 0.0..3.0f64,
        pause in (-6.0..4.94f64).prop_map(|digits| 10_f64.powf(digits)),
        played in any::<bool>(), holds_for_ever in any::<bool>(), slow in any::<bool>(),
    ) {
        let mut drive = Drive::default();
        if slow {
            (drive.max_linear_acceleration, drive.max_angular_acceleration) = (1e-5, 1e-4);
        }
        let mut commands = Commands::default();
        let watchdog = if holds_for_ever { 0.0 } else { 0.3 };
        for sequence in 0..first {
            let start = t(base + sequence as f64 * SLOT);
            let horizon = commands.begin(sequence as u64, start, SLOT, watchdog);
            let speeds = (0..slots).map(|slot| 1.0 + 0.01 * slot as f64);
            horizon.speeds.extend(speeds.map(|speed| WheelSpeeds { left: speed, right: speed }));
            commands.report(Playing { horizon: sequence as u64, since: start }, start + SLOT / 2.0);
        }
        let attribution = if played { Attribution::Played } else { Attribution::Sent };
        let last = t(base + first as f64 * SLOT);
        let (from, to) = (last - back, last + pause);
        let (mut sum, mut pieces) = (0.0, 0);
        commands.walk(attribution, &drive, from, to, |_, duration| {
            assert!(duration > 0.0, "time stands still at {}", from + sum);
            sum += duration;
            pieces += 1;
            assert!(pieces <= MOST_PIECES + 1);
        });
        // Each piece begins and ends at numbers that the clock can say, so little is lost in their sum.
        let digits = 1e-9 + 1e-12 * (to - from) + pieces as f64 * f64::EPSILON * (to - from);
        prop_assert!((sum - (to - from)).abs() <= digits, "{sum} of {}", to - from);
    }
}
