//! The server is killed again and again while robots drive, an evolution runs and people change things.
//!
//! Every life of it is a server of its own on the same data and at the same address. Where a kill falls comes from a
//! seed, which is printed: `UMWELT_TEST_SEED` repeats it, as far as the machine does.

mod changes;
mod evolution;
mod robots;

use changes::Changes;
use evolution::Evolutions;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use robots::{Robots, SAVE_EVERY_S};
use std::net::SocketAddr;
use std::time::{Duration, Instant};
use umwelt_tests::data::Data;
use umwelt_tests::process::Process;
use umwelt_tests::server::Server;

/// Kills in the midst of everything, and of servers that have only begun.
const KILLS: u32 = 16;
const EARLY_KILLS: u32 = 5;

/// How long a life lasts in which everything goes on.
const LIFE: std::ops::Range<f64> = 0.3..2.5;

/// How long a server has at most before an early kill: enough to be anywhere in its start.
const BEGINNING: std::ops::Range<f64> = 0.0..0.15;

/// Lives that must have been long enough to tell whether what robots learned is young enough. Early ones are: later a
/// robot has learned so much that what it learns within one is hardly news.
const TELLING: usize = 1;

fn seed() -> u64 {
    let asked = std::env::var("UMWELT_TEST_SEED").ok().and_then(|seed| seed.parse().ok());
    asked.unwrap_or(20)
}

/// A part of a life that a fault ends.
async fn live(rng: &mut Pcg64Mcg, seconds: std::ops::Range<f64>) {
    tokio::time::sleep(Duration::from_secs_f64(rng.random_range(seconds))).await;
}

/// Guards against: something that was acknowledged is not there, or only half, or was there before and is again.
#[tokio::test(flavor = "multi_thread")]
async fn whatever_was_acknowledged_outlives_a_kill_at_any_moment() {
    let seed = seed();
    println!("UMWELT_TEST_SEED={seed}");
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let data = Data::new();
    let settings = ["--data", data.text(), "--save-every-s", SAVE_EVERY_S];
    let mut server = Server::start_with(&settings);
    let address = server.address;
    Changes::prepare(address).await;
    let mut changes = Changes::new(seed);
    let mut evolutions = Evolutions::begin(address).await;
    let mut robots = Robots::start(&server).await;
    evolutions.until_first_generation(&server).await;
    let mut early: Vec<u32> = (0..EARLY_KILLS).map(|_| rng.random_range(0..KILLS)).collect();
    for kill in 0..KILLS {
        let changing = changes.start(address);
        let watching = robots.watch(address);
        let following = evolutions.follow(address);
        live(&mut rng, LIFE).await;
        let killed = Instant::now();
        server.process.kill();
        changes = changing.ended().await;
        robots = watching.ended().await;
        evolutions = following.ended().await;

        robots.check_kept(&data, killed).await;
        while let Some(index) = early.iter().position(|early| *early == kill) {
            early.swap_remove(index);
            kill_early(&mut rng, address, &data).await;
        }
        server = Server::start_on(&address.to_string(), &settings);
        changes.check(address).await;
        evolutions.check(address).await;
        robots.go_on(&server).await;
    }
    let (acknowledged, in_doubt) = (changes.acknowledged(), changes.in_doubt());
    println!("{acknowledged} changes acknowledged, {in_doubt} in doubt, all kills survived");
    assert!(acknowledged > 10 * u64::from(KILLS), "{acknowledged}");
    let telling = robots.telling();
    println!("{telling} lives tell how old what robots learned is");
    assert!(telling >= TELLING, "{telling} lives tell how old what robots learned is");
    robots.end(&server).await;
    println!("evolutions interrupted {:?} times", evolutions.succeed(&server).await);
}

/// A server that is killed before, while or just after it takes up what is kept.
async fn kill_early(rng: &mut Pcg64Mcg, address: SocketAddr, data: &Data) {
    let listen = address.to_string();
    let mut process =
        Process::start("umwelt-server", &["--listen", &listen, "--data", data.text()]);
    live(rng, BEGINNING).await;
    process.kill();
}
