use super::*;
use crate::fleet::feed::Feed;
use crate::fleet::robot::Workers;
use crate::library::priors::Priors;
use crate::program::config::Config;
use crate::store::MemoryStore;
use crate::store::StoredRobot;
use std::time::Duration;
use umwelt_api::problem::reason;
use umwelt_api::robot::State;
use umwelt_core::exchange::Request;
use umwelt_core::settings::Settings;
use umwelt_core::time::RobotTime;

fn empty() -> Fleet {
    open(Vec::new())
}

fn open(robots: Vec<StoredRobot>) -> Fleet {
    let keeper = Keeper::new(Arc::new(MemoryStore::default()));
    let Config { max_robots, save_every, lost_after, .. } = Config::default();
    let feed = Feed::new();
    let workers = Workers::start().unwrap();
    let common = Common { lost_after, feed, priors: Priors::default(), workers };
    Fleet::open(
        max_robots,
        save_every,
        keeper,
        common,
        robots,
        Stops::default(),
        Default::default(),
    )
}

#[tokio::test]
async fn a_robot_whose_task_has_died_drives_again_once_it_is_described_anew() {
    let fleet = empty();
    let dead = Arc::new(Robot::dead("r").await);
    fleet.0.robots.write().unwrap().insert(dead.id().clone(), Arc::clone(&dead));
    assert!(fleet.stop_all().await.is_err(), "nobody may think that it was told");
    let (robot, put) = fleet
        .put(dead.id().clone(), Told::all(Settings::default()), Condition::default())
        .await
        .unwrap();
    assert_eq!(put, Put::Replaced);
    assert!(robot.is_alive());
    assert_eq!(fleet.stop_all().await, Ok((1, true)));
    fleet.delete(robot, Condition::default()).await.unwrap();
    assert!(fleet.find(dead.id()).is_none());
}

/// Guards against: one robot whose computation does not end takes the server with it, cannot be stopped, or cannot
/// be removed; and as many of them as there are threads hold up all others.
#[tokio::test(flavor = "multi_thread", worker_threads = 1)]
async fn robots_that_compute_for_ever_hold_up_no_one_and_can_be_stopped() {
    let fleet = empty();
    let mut robots = Vec::new();
    for id in ["a", "b", "c", "d", "e", "well"] {
        let (id, settings) = (id.parse().unwrap(), Settings::default());
        robots.push(fleet.put(id, Told::all(settings), Condition::default()).await.unwrap().0);
    }
    let well = robots.pop().unwrap();
    let mut releases = Vec::new();
    for robot in &robots {
        robot.step(step(1), 7).await.unwrap();
        let (release, released) = std::sync::mpsc::channel::<()>();
        robot.compute(move || {
            let _ = released.recv();
        });
        releases.push(release);
    }
    // Whoever waits for such a robot hears that it has failed, and so does whoever comes later.
    for _ in 0..2 {
        for robot in &robots {
            let refused = format!("{:?}", robot.step(step(2), 7).await.unwrap_err());
            assert!(refused.contains(reason::ROBOT_FAILED), "{refused}");
        }
    }
    assert_eq!(robots[0].snapshot().state(), State::Failed);
    assert!(well.step(step(1), 7).await.is_ok());
    assert_eq!(well.snapshot().state(), State::Connected);
    let task = Task::thesis();
    for robot in &robots {
        let put = fleet.put_task(Arc::clone(robot), task.clone(), Condition::default()).await;
        assert!(format!("{:?}", put.unwrap_err()).contains(reason::ROBOT_FAILED));
    }
    // All of them are told; the others rest at once, these as soon as they can.
    assert_eq!(fleet.stop_all().await, Ok((6, true)));
    assert!(robots[0].snapshot().robot(robots[0].id(), tokio::time::Instant::now()).stopped);
    assert!(well.step(step(2), 7).await.unwrap().stopped);
    let resumed = fleet.resume(Arc::clone(&robots[0])).await;
    assert!(format!("{:?}", resumed.unwrap_err()).contains(reason::ROBOT_FAILED));
    fleet.delete(robots.pop().unwrap(), Condition::default()).await.unwrap();
    assert!(fleet.find(&"e".parse().unwrap()).is_none());
    // The server can end although they do not.
    fleet.drain().await;
    drop(releases);
    for robot in &robots {
        while robot.has_failed() {
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
        let reply = robot.step(step(3), 7).await.unwrap();
        assert!(reply.stopped, "it goes on where it was, and heard the stop");
    }
}

fn step(sequence: u64) -> Request {
    Request { sequence, sent: RobotTime::new(sequence as f64), ..Request::EMPTY }
}

/// Guards against: what an earlier version took can no longer be named, and drives on.
#[tokio::test]
async fn a_robot_of_an_earlier_version_whose_id_begins_with_a_hyphen_goes_on() {
    let (settings, id) = (Settings::default(), "-r".parse::<RobotId>().unwrap());
    let record = Record { told: Told::all(settings), task: None, stopped: false, revision: 1 };
    let stored = StoredRobot { id: id.clone(), record, saved: None };
    let fleet = open(vec![stored]);
    let put = async |id: &RobotId| {
        fleet.put(id.clone(), Told::all(Settings::default()), Condition::default()).await
    };
    let (robot, done) = put(&id).await.unwrap();
    assert_eq!(done, Put::Replaced);
    fleet.delete(robot, Condition::default()).await.unwrap();
    assert!(put(&id).await.is_err(), "nothing new goes by it");
}

#[tokio::test]
async fn a_robot_whose_task_has_died_can_be_removed() {
    let fleet = empty();
    let dead = Arc::new(Robot::dead("r").await);
    fleet.0.robots.write().unwrap().insert(dead.id().clone(), Arc::clone(&dead));
    fleet.delete(Arc::clone(&dead), Condition::default()).await.unwrap();
    assert!(fleet.find(dead.id()).is_none());
}
