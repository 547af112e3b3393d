//! One run: server, agents, tasks, and waiting until everybody has arrived.

use crate::{Attribution, Method, Options, show};
use serde::Serialize;
use std::error::Error;
use std::time::Duration;
use tokio::sync::oneshot;
use tokio::task::JoinSet;
use tokio::time::{Instant, MissedTickBehavior, interval};
use umwelt_agent::{Clock, Config, drive::Sim, transport};
use umwelt_api::{RobotId, environment::Environment, robot, task};
use umwelt_client::Client;
use umwelt_core::exchange::PoseNoise;
use umwelt_core::geometry::Pose;
use umwelt_core::link::LinkModel;
use umwelt_core::plant::{PlantModel, Slip};
use umwelt_core::settings;
use umwelt_core::task::Task;
use umwelt_server::Server;

/// The floors, in turn.
const FLOORS: [(&str, Slip); 3] =
    [("hard", Slip::HARD), ("dusty", Slip::DUSTY), ("slippery", Slip::SLIPPERY)];

/// How often the table is drawn and the tasks are looked at.
const LOOK: Duration = Duration::from_millis(500);

/// How one robot did.
#[derive(Debug, Serialize)]
pub struct Finish {
    pub robot: RobotId,
    pub floor: &'static str,
    pub seed: u64,
    pub arrived: bool,
    pub time_s: f64,
    pub max_deviation_m: f64,
    pub environment: Environment,
}

/// How the fleet did.
#[derive(Debug, Serialize)]
pub struct Summary {
    pub link: String,
    pub slots: u16,
    pub method: robot::Method,
    pub wall_time_s: f64,
    pub robots: Vec<Finish>,
    pub median_time_s: f64,
    pub median_deviation_m: f64,
    pub p90_deviation_m: f64,
}

impl Summary {
    pub fn all_arrived(&self) -> bool {
        self.robots.iter().all(|finish| finish.arrived)
    }
}

/// One robot of the fleet before it drives.
pub struct Member {
    pub robot: RobotId,
    pub floor: &'static str,
    slip: Slip,
    seed: u64,
    /// Seed of this robot's floor, camera and link.
    own_seed: u64,
}

/// Drives `options.robots` robots for each of `seeds`, all at the same time.
pub async fn fleet(
    options: &Options,
    seeds: &[u64],
    slots: u16,
    link: &str,
) -> Result<Summary, Box<dyn Error>> {
    let begun = Instant::now();
    let link_model = LinkModel::preset(link).ok_or("no such link")?;
    let config = umwelt_server::Config {
        listen: ([127, 0, 0, 1], 0).into(),
        ..umwelt_server::Config::default()
    };
    let server = Server::bind(config).await?;
    let url = format!("http://{}", server.local_addr());
    let (stop_server, server_stopped) = oneshot::channel::<()>();
    let serving = tokio::spawn(server.run(async {
        server_stopped.await.unwrap_or_default();
    }));

    let client = Client::new(&url)?;
    let members = members(options, seeds)?;
    let settings = settings(options, slots);
    let said = robot::Description::from(&robot::Spec::from(&settings));
    let mut agents = JoinSet::new();
    for member in &members {
        client.put_robot(&member.robot, &said).await?;
        client.set_task(&member.robot, &task::Spec::from(&Task::thesis())).await?;
        let plant = PlantModel {
            drive: settings.drive,
            slip: member.slip,
            noise: settings.noise,
            ..PlantModel::default()
        };
        let drive = Sim::new(plant, Pose::default(), member.own_seed)?
            .with_sensor_delay(link_model.sensor_delay);
        let config = Config {
            link: Some(link_model.clone()),
            seed: member.own_seed,
            ..Config::new(member.robot.clone())
        };
        let connect = transport::http(&url, member.robot.clone())?;
        let forever = std::future::pending();
        agents.spawn(umwelt_agent::run(config, connect, drive, Clock::start(), forever));
    }

    let followed = follow(options, &client, &members, &mut agents).await;
    agents.shutdown().await;
    let finishes = match followed {
        Ok(()) => finishes(&client, &members).await,
        Err(error) => Err(error),
    };
    drop(stop_server);
    serving.await??;

    let robots = finishes?;
    let times = robots.iter().map(|finish| finish.time_s).collect();
    let deviations: Vec<f64> = robots.iter().map(|finish| finish.max_deviation_m).collect();
    Ok(Summary {
        link: link.to_owned(),
        slots,
        method: settings.method.into(),
        wall_time_s: begun.elapsed().as_secs_f64(),
        median_time_s: quantile(times, 0.5),
        median_deviation_m: quantile(deviations.clone(), 0.5),
        p90_deviation_m: quantile(deviations, 0.9),
        robots,
    })
}

/// Looks at the fleet until everybody has arrived or the time is over.
async fn follow(
    options: &Options,
    client: &Client,
    members: &[Member],
    agents: &mut JoinSet<Result<umwelt_agent::Report, umwelt_agent::AgentError>>,
) -> Result<(), Box<dyn Error>> {
    let begun = Instant::now();
    let mut looks = interval(LOOK);
    looks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut table = show::Live::new();
    loop {
        tokio::select! {
            _ = looks.tick() => {}
            Some(ended) = agents.join_next() => {
                ended??;
                return Err("an agent ended before its robot arrived".into());
            }
        }
        let mut rows = Vec::with_capacity(members.len());
        for member in members {
            rows.push(client.get_robot(&member.robot).await?);
        }
        table.draw(client, members, &rows, begun.elapsed()).await?;
        let arrived = |row: &robot::Robot| {
            row.task.as_ref().is_some_and(|task| task.stage == task::Stage::Arrived)
        };
        if rows.iter().all(arrived) || begun.elapsed() > Duration::from_secs(options.timeout) {
            return Ok(());
        }
    }
}

/// How everybody did, as the server knows it.
async fn finishes(client: &Client, members: &[Member]) -> Result<Vec<Finish>, Box<dyn Error>> {
    let mut finishes = Vec::with_capacity(members.len());
    for member in members {
        let progress = client.get_task(&member.robot).await?.progress;
        finishes.push(Finish {
            robot: member.robot.clone(),
            floor: member.floor,
            seed: member.seed,
            arrived: progress.stage == task::Stage::Arrived,
            time_s: progress.elapsed_s,
            max_deviation_m: progress.max_deviation_m,
            environment: client.environment(&member.robot).await?,
        });
    }
    Ok(finishes)
}

fn members(options: &Options, seeds: &[u64]) -> Result<Vec<Member>, Box<dyn Error>> {
    let mut members = Vec::new();
    for &seed in seeds {
        for number in 1..=u64::from(options.robots) {
            let (floor, slip) = FLOORS[(number as usize - 1) % FLOORS.len()];
            let name = match seeds.len() {
                1 => format!("robot-{number}"),
                _ => format!("seed-{seed}-robot-{number}"),
            };
            let own_seed = seed.wrapping_mul(1000).wrapping_add(number);
            members.push(Member { robot: name.parse()?, floor, slip, seed, own_seed });
        }
    }
    Ok(members)
}

fn settings(options: &Options, slots: u16) -> settings::Settings {
    settings::Settings {
        noise: PoseNoise::CAMERA,
        slots: slots.into(),
        method: match options.method {
            Method::FixedNormal => settings::Method::FixedNormal,
            Method::FixedBad => settings::Method::FixedBad,
            Method::Statistic => settings::Method::Statistic,
            Method::Bayesian => settings::Method::Bayesian,
        },
        attribution: match options.attribution {
            Attribution::Sent => settings::Attribution::Sent,
            Attribution::Played => settings::Attribution::Played,
        },
        ..settings::Settings::default()
    }
}

/// The value below which `share` of `values` lie, nearest rank; at least one value.
fn quantile(mut values: Vec<f64>, share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values[((values.len() - 1) as f64 * share).round() as usize]
}
