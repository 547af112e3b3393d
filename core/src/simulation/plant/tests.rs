use super::*;
use crate::geometry::Displacement;
use crate::geometry::Twist;
use crate::kinematics::{integrate, inverse};
use proptest::prelude::*;

const FAST: Twist = Twist::new(0.13, 0.0);

fn plant(drive: Drive, slip: Slip, seed: u64) -> Plant {
    let model = PlantModel { drive, slip, noise: PoseNoise::NONE, ..PlantModel::default() };
    Plant::new(model, Pose::default(), seed).unwrap()
}

fn wheels(twist: Twist) -> WheelSpeeds {
    inverse(&Drive::default(), twist)
}

fn channel(mean: f64, sd: f64) -> SlipChannel {
    SlipChannel::new(mean, sd).unwrap()
}

fn distance(a: Pose, b: Pose) -> f64 {
    a.point().distance(b.point()) + a.heading.minus(b.heading).abs()
}

/// Mean and standard deviation of `samples`.
fn moments(samples: &[f64]) -> (f64, f64) {
    let n = samples.len() as f64;
    let mean = samples.iter().sum::<f64>() / n;
    (mean, (samples.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt())
}

/// Checks samples of a normal of `mean` and `sd` to four standard errors: sd/sqrt(n) and sd/sqrt(2n).
fn assert_normal(samples: &[f64], mean: f64, sd: f64) {
    let n = samples.len() as f64;
    let got = moments(samples);
    assert!((got.0 - mean).abs() < 4.0 * sd / n.sqrt(), "mean {} for {mean}", got.0);
    assert!((got.1 - sd).abs() < 4.0 * sd / (2.0 * n).sqrt(), "sd {} for {sd}", got.1);
}

/// The displacements of `n` successive windows of `window` s, in pieces of `piece` s, at constant `twist`.
fn windows(slip: Slip, twist: Twist, n: usize, window: f64, piece: f64) -> Vec<Displacement> {
    let mut plant = plant(Drive::default(), slip, 42);
    (0..n)
        .map(|_| {
            let start = plant.pose();
            let pieces = (window / piece).round() as usize;
            (0..pieces).for_each(|_| plant.advance(wheels(twist), window / pieces as f64));
            plant.pose().relative_to(start)
        })
        .collect()
}

#[test]
fn the_ratio_over_100_ms_has_mean_and_sd_of_its_channel() {
    let n = 20_000;
    let channels = [channel(-0.1, 0.15), channel(0.05, 0.08), channel(0.2, 0.3), channel(0.4, 0.2)];
    let none = Slip::NONE;
    // one channel at a time, however the window is cut: exactly at cells, within them, and as a whole
    for piece in [0.1, 0.03, 0.007, 0.001] {
        let straight = |slip| windows(slip, FAST, n, 0.1, piece);
        let ratios: Vec<_> = straight(Slip { forward: channels[0], ..none })
            .iter()
            .map(|d| d.forward / 0.013 - 1.0)
            .collect();
        assert_normal(&ratios, -0.1, 0.15);
        let ratios: Vec<_> = straight(Slip { lateral: channels[1], ..none })
            .iter()
            .map(|d| d.lateral / 0.013)
            .collect();
        assert_normal(&ratios, 0.05, 0.08);
        let ratios: Vec<_> =
            straight(Slip { drift: channels[3], ..none }).iter().map(|d| d.turn / 0.013).collect();
        assert_normal(&ratios, 0.4, 0.2);
        let turning =
            windows(Slip { turn: channels[2], ..none }, Twist::new(0.0, 1.0), n, 0.1, piece);
        let ratios: Vec<_> = turning.iter().map(|d| d.turn / 0.1 - 1.0).collect();
        assert_normal(&ratios, 0.2, 0.3);
    }
}

#[test]
fn over_longer_windows_the_sd_falls_as_the_root_of_the_time() {
    let slip = Slip { forward: channel(0.0, 0.15), ..Slip::NONE };
    let ratios: Vec<_> =
        windows(slip, FAST, 5_000, 1.0, 0.03).iter().map(|d| d.forward / 0.13 - 1.0).collect();
    assert_normal(&ratios, 0.0, 0.15 / 10f64.sqrt());
    // white: successive windows are uncorrelated, their normalised products have sd 1
    let products: Vec<_> =
        ratios.windows(2).map(|w| w[0] * w[1] / (0.15f64.powi(2) / 10.0)).collect();
    assert!(moments(&products).0.abs() < 4.0 / (products.len() as f64).sqrt());
}

#[test]
fn a_changing_speed_weighs_the_error_by_its_square() {
    // Var(ratio) = sd^2 0.1 s int v^2 dt/(int v dt)^2 (U1 of docs/method.md), here with 0.1 s at each speed
    let slip = Slip { forward: channel(0.0, 0.2), ..Slip::NONE };
    let mut plant = plant(Drive::default(), slip, 8);
    let ratios: Vec<_> = (0..10_000)
        .map(|_| {
            let start = plant.pose();
            plant.advance(wheels(Twist::new(0.12, 0.0)), 0.1);
            plant.advance(wheels(Twist::new(0.04, 0.0)), 0.1);
            plant.pose().relative_to(start).forward / 0.016 - 1.0
        })
        .collect();
    let (squares, length) = (0.1 * (0.12f64.powi(2) + 0.04f64.powi(2)), 0.016f64);
    assert_normal(&ratios, 0.0, (0.04 * 0.1 * squares / length.powi(2)).sqrt());
}

#[test]
fn a_constant_slip_is_what_small_steps_sum_to() {
    let slip = Slip {
        forward: channel(-0.2, 0.0),
        lateral: channel(0.1, 0.0),
        turn: channel(-0.3, 0.0),
        drift: channel(0.5, 0.0),
    };
    let mut plant = plant(Drive::default(), slip, 1);
    plant.advance(wheels(Twist::new(0.1, 0.8)), 2.0);
    let (mut x, mut y, n) = (0.0, 0.0, 200_000);
    let rate = 0.8 * 0.7 + 0.1 * 0.5;
    for i in 0..n {
        let h = 2.0 / f64::from(n);
        let (sin, cos) = (rate * h * (f64::from(i) + 0.5)).sin_cos();
        x += h * (0.08 * cos - 0.01 * sin);
        y += h * (0.08 * sin + 0.01 * cos);
    }
    assert!(distance(plant.pose(), Pose::new(x, y, 2.0 * rate)) < 1e-9);
}

#[test]
fn lag_follows_the_closed_form() {
    let drive = Drive { lag: 0.12, ..Drive::default() };
    let mut plant = plant(drive, Slip::NONE, 1);
    plant.advance(wheels(FAST), 0.3);
    // w(t) = u (1 - e^(-t/lag)), x(t) = v (t - lag (1 - e^(-t/lag)))
    let share = 1.0 - (-0.3f64 / 0.12).exp();
    assert!((plant.wheel_speeds().left - wheels(FAST).left * share).abs() < 1e-12);
    assert!((plant.pose().x - 0.13 * (0.3 - 0.12 * share)).abs() < 1e-12);
}

#[test]
fn dead_time_shifts_what_was_commanded() {
    let drive = Drive { dead_time: 0.1, ..Drive::default() };
    let (mut late, mut prompt) =
        (plant(drive, Slip::NONE, 1), plant(Drive::default(), Slip::NONE, 1));
    let twists = [FAST, Twist::new(0.05, 1.0), Twist::new(0.0, -1.2), Twist::new(-0.1, 0.1)];
    for i in 0..40usize {
        late.advance(wheels(twists[i / 3 % 4]), 0.03);
    }
    for i in 0..40usize {
        // 1.2 s less 0.1 s: 36 whole slots and two thirds of one
        let duration = [0.03, 0.02, 0.0][i.saturating_sub(35).min(2)];
        prompt.advance(wheels(twists[i / 3 % 4]), duration);
    }
    assert!(distance(late.pose(), prompt.pose()) < 1e-12);
    let mut other = plant(drive, Slip::NONE, 1);
    other.advance(wheels(FAST), 0.099);
    assert_eq!((other.pose(), other.wheel_speeds()), (Pose::default(), WheelSpeeds::ZERO));
    other.advance(WheelSpeeds::ZERO, 0.1005);
    assert!((other.pose().x - 0.13 * 0.099).abs() < 1e-12);
    assert_eq!(other.wheel_speeds(), WheelSpeeds::ZERO);
}

#[test]
fn more_commands_than_can_wait_replace_the_last() {
    let drive = Drive { dead_time: 1.0, ..Drive::default() };
    let mut plant = plant(drive, Slip::NONE, 1);
    for i in 0..200 {
        plant.advance(WheelSpeeds { left: 0.01 * f64::from(i), right: 0.0 }, 0.004);
    }
    let last = WheelSpeeds { left: 3.0, right: 3.0 };
    plant.advance(last, 2.0);
    assert_eq!(plant.wheel_speeds(), last);
}

#[test]
fn observations_have_the_noise_of_the_camera_and_do_not_touch_the_floor() {
    let model = PlantModel { noise: PoseNoise::CAMERA, slip: Slip::RAMP, ..PlantModel::default() };
    let start = Pose::new(1.0, 2.0, 3.13);
    let (mut seen, mut unseen) =
        (Plant::new(model, start, 6).unwrap(), Plant::new(model, start, 6).unwrap());
    let poses: Vec<_> = (0..20_000).map(|_| seen.observe()).collect();
    let errors = |f: fn(&Pose) -> f64| poses.iter().map(f).collect::<Vec<_>>();
    assert_normal(&errors(|p| p.x - 1.0), 0.0, 0.0005);
    assert_normal(&errors(|p| p.y - 2.0), 0.0, 0.0005);
    assert_normal(&errors(|p| p.heading.minus(3.13.into())), 0.0, 0.003);
    seen.advance(wheels(FAST), 1.0);
    unseen.advance(wheels(FAST), 1.0);
    assert_eq!(seen.pose(), unseen.pose());
}

#[test]
fn a_floor_that_changes_keeps_its_draws() {
    let (mut one, mut two) =
        (plant(Drive::default(), Slip::RAMP, 3), plant(Drive::default(), Slip::NONE, 3));
    one.advance(wheels(FAST), 0.5);
    two.advance(wheels(Twist::new(0.0, 1.0)), 0.2);
    two.advance(wheels(FAST), 0.3);
    two.set_slip(Slip::RAMP);
    let (a, b) = (one.pose(), two.pose());
    one.advance(wheels(FAST), 0.5);
    two.advance(wheels(FAST), 0.5);
    let (a, b) = (one.pose().relative_to(a), two.pose().relative_to(b));
    assert!((a.forward - b.forward).abs() < 1e-12 && (a.turn - b.turn).abs() < 1e-12);
}

#[test]
fn what_means_nothing_is_refused_with_its_value_and_never_moves_the_robot() {
    let good = PlantModel::default();
    let drive = |drive| PlantModel { drive, ..good };
    let d = Drive::default();
    let noise = |position, heading| PlantModel { noise: PoseNoise { position, heading }, ..good };
    let refused = [
        drive(Drive { wheel_radius: 0.0, ..d }),
        drive(Drive { track_width: f64::NAN, ..d }),
        drive(Drive { max_wheel_speed: f64::INFINITY, ..d }),
        drive(Drive { lag: -0.1, ..d }),
        drive(Drive { dead_time: f64::NAN, ..d }),
        drive(Drive { dead_time: 1.1, ..d }),
        noise(-0.1, 0.0),
        noise(0.0, f64::INFINITY),
        PlantModel { dead_band: -0.1, ..good },
    ];
    for model in refused {
        assert!(Plant::new(model, Pose::default(), 1).is_err(), "{model:?}");
    }
    assert!(Plant::new(good, Pose::new(f64::NAN, 0.0, 0.0), 1).is_err());
    let mut plant = plant(d, Slip::NONE, 1);
    plant.advance(WheelSpeeds { left: f64::NAN, right: f64::NAN }, 1.0);
    for duration in [f64::NAN, f64::INFINITY, -1.0, 0.0] {
        plant.advance(wheels(FAST), duration);
    }
    assert_eq!((plant.pose(), plant.time()), (Pose::default(), 1.0));
    plant.advance(WheelSpeeds { left: f64::INFINITY, right: 99.0 }, 1.0);
    assert!((plant.pose().x - 8.0 * 0.03).abs() < 1e-12);
}

/// Guards against: a wheel that creeps below its dead band, or is slower than commanded above it.
#[test]
fn a_wheel_turns_as_commanded_above_its_dead_band_and_not_below() {
    let model = PlantModel { dead_band: 1.0, ..PlantModel::default() };
    let mut plant = Plant::new(model, Pose::default(), 1).unwrap();
    plant.advance(WheelSpeeds { left: 1.0, right: -0.9 }, 1.0);
    assert_eq!(plant.pose(), Pose::default());
    plant.advance(WheelSpeeds { left: 0.99, right: 1.01 }, 1.0);
    assert_eq!(plant.wheel_speeds(), WheelSpeeds { left: 0.0, right: 1.01 });
    assert!((plant.pose().heading.radians() - 1.01 * 0.03 / 0.1).abs() < 1e-9);
}

proptest! {
    #[test]
    fn without_slip_lag_and_dead_time_it_is_the_exact_arc(
        v in -0.13..0.13f64, w in -1.25..1.25f64, t in 0.0..3.0f64, seed: u64,
    ) {
        let mut plant = plant(Drive::default(), Slip::NONE, seed);
        plant.advance(wheels(Twist::new(v, w)), t);
        let exact = Pose::default().then(integrate(Twist::new(v, w), t));
        prop_assert!(distance(plant.pose(), exact) < 1e-9);
        prop_assert_eq!(plant.time(), t);
    }

    #[test]
    fn the_path_does_not_depend_on_how_the_time_is_cut(
        cuts in proptest::collection::vec(0.0..0.05f64, 1..40), seed: u64, lag in 0.0..0.2f64, dead_time in 0.0..0.2f64,
    ) {
        let drive = Drive { lag, dead_time, ..Drive::default() };
        let (mut whole, mut cut) = (plant(drive, Slip::SLIPPERY, seed), plant(drive, Slip::SLIPPERY, seed));
        for twist in [FAST, Twist::new(0.05, 0.9)] {
            whole.advance(wheels(twist), cuts.iter().sum());
            cuts.iter().for_each(|&piece| cut.advance(wheels(twist), piece));
        }
        // within a cell the speed of a lagging wheel changes a little, and with it the curve
        prop_assert!(distance(whole.pose(), cut.pose()) < 1e-5);
        prop_assert!((whole.wheel_speeds().left - cut.wheel_speeds().left).abs() < 1e-9);
    }

    #[test]
    fn equal_seeds_give_equal_paths_and_others_do_not(seed: u64) {
        let run = |seed| {
            let model = PlantModel { slip: Slip::DUSTY, noise: PoseNoise::CAMERA, ..PlantModel::default() };
            let mut plant = Plant::new(model, Pose::default(), seed).unwrap();
            plant.advance(wheels(FAST), 0.5);
            (plant.observe(), plant.pose())
        };
        prop_assert_eq!(run(seed), run(seed));
        prop_assert_ne!(run(seed).1, run(seed ^ 1).1);
        prop_assert_ne!(run(seed).0, run(seed).1);
    }
}
