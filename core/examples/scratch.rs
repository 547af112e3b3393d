#![allow(missing_docs, clippy::print_stdout, clippy::unwrap_used)]
use umwelt_core::controller::settings::*;
use umwelt_core::controller::task::*;
use umwelt_core::episode::*;
use umwelt_core::geometry::Pose;
use umwelt_core::link::LinkModel;
use umwelt_core::plant::{PlantModel, Slip};
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let get = |n: &str, d: &str| {
        args.iter().position(|a| a == n).map_or(d.to_string(), |i| args[i + 1].clone())
    };
    let n: u64 = get("--n", "50").parse().unwrap();
    let noise = get("--noise", "0") == "1";
    let lag: f64 = get("--lag", "0").parse().unwrap();
    let slip = get("--slip", "none");
    let calib = get("--calib", "1") == "1";
    let method = match get("--method", "bayesian").as_str() {
        "fixed-normal" => Method::FixedNormal,
        "fixed-bad" => Method::FixedBad,
        "statistic" => Method::Statistic,
        _ => Method::Bayesian,
    };
    for slots in [1usize, 20] {
        for link in ["clean", "normal", "bad", "wifi-bursty"] {
            let mut settings = Settings { slots, method, ..Settings::default() };
            settings.drive.lag = lag;
            let mut plant = PlantModel {
                slip: Slip::preset(&slip).unwrap(),
                drive: settings.drive,
                ..PlantModel::default()
            };
            if noise {
                plant.noise = PoseNoise::CAMERA;
                settings.noise.position = 0.0005;
                settings.noise.heading = 0.003;
            }
            if get("--played", "0") == "1" {
                settings.attribution = Attribution::Played;
            }
            let mut task = Task::thesis();
            if !calib {
                task.calibration = None;
            }
            let sc = Scenario {
                settings,
                plant,
                link: LinkModel::preset(link).unwrap(),
                task,
                start: Pose::new(0.0, 0.0, 0.0),
                time_limit: 300.0,
            };
            if get("--trace", "") == link && slots.to_string() == get("--slots", "20") {
                let seed = get("--seed", "1").parse().unwrap();
                let (o, rows) = sc.trace(seed).unwrap();
                for r in rows {
                    println!(
                        "{:.4} {:?} leg{} x {:.4} y {:.4} h {:.4} v {:.2} {:.2} dev {:.4}",
                        r.time,
                        r.stage,
                        r.leg,
                        r.pose.x,
                        r.pose.y,
                        r.pose.heading.radians(),
                        r.applied.left,
                        r.applied.right,
                        r.deviation
                    );
                }
                println!("{o:#?}");
                return;
            }
            let t0 = std::time::Instant::now();
            let (mut t, mut d, mut arrived) = (vec![], vec![], 0);
            let mut sim = 0.0;
            let mut worst = (0.0, 0);
            for seed in 0..n {
                let mut end = 0.0;
                let (o, _) = sc.run_with(seed, |r| end = r.time).unwrap();
                sim += end;
                arrived += u64::from(o.arrived);
                if !o.arrived {
                    println!("seed {seed} not arrived {o:?}");
                }
                if o.max_deviation > worst.0 {
                    worst = (o.max_deviation, seed);
                }
                t.push(o.time);
                d.push(o.max_deviation * 1e3);
            }
            t.sort_by(f64::total_cmp);
            d.sort_by(f64::total_cmp);
            let q = |v: &Vec<f64>, p: f64| v[((v.len() - 1) as f64 * p) as usize];
            println!(
                "slots {slots:2} {link:12} arrived {arrived}/{n} time med {:.2} p90 {:.2} dev med {:.2} p90 {:.2} max {:.2}(seed {})  us/slot {:.2}",
                q(&t, 0.5),
                q(&t, 0.9),
                q(&d, 0.5),
                q(&d, 0.9),
                worst.0 * 1e3,
                worst.1,
                t0.elapsed().as_secs_f64() * 1e6 / (sim / 0.03)
            );
        }
    }
}
