//! The fleet of a server that starts: what its store keeps, and the tasks that keep what the robots learn and are told.

use super::keeping::{self, Stops, Unkept};
use super::{Fleet, Inner, saving};
use crate::fleet::robot::{Arrivals, Common};
use crate::store::{Keeper, Kind, StoredRobot, Unreadables};
use std::sync::atomic::{AtomicBool, AtomicU64};
use std::sync::{Arc, RwLock};
use std::time::Duration;
use tokio::sync::Mutex;
use umwelt_api::RobotId;

impl Fleet {
    /// The robots that the store keeps; what they learn is kept from now on as long as the fleet is there.
    pub(crate) fn open(
        max_robots: usize,
        save_every: Duration,
        keeper: Keeper,
        common: Common,
        robots: Vec<StoredRobot>,
        stops: Stops,
        unreadable: Unreadables,
    ) -> Self {
        let earlier = stops.words.newest();
        let is_unreadable = |id: &RobotId| unreadable.has(Kind::Robot, id.as_str());
        let ids = robots.iter().map(|robot| robot.id.clone());
        let unkept = Unkept::of(&stops.words, ids, is_unreadable);
        let revisions = robots.iter().map(|robot| robot.record.revision);
        let revision = revisions.chain(unreadable.revisions()).max();
        let fleet = Self(Arc::new(Inner {
            robots: RwLock::default(),
            creating: Mutex::default(),
            keeper,
            saver: Mutex::default(),
            arrivals: Arrivals::after(earlier),
            earlier: earlier.max(1),
            journal: stops.journal.clone(),
            unkept: std::sync::Mutex::new(unkept),
            behind: Arc::default(),
            revision: AtomicU64::new(revision.unwrap_or(0)),
            unreadable,
            common,
            max_robots,
            draining: AtomicBool::new(false),
        }));
        for StoredRobot { id, mut record, saved } in robots {
            stops.merge(&id, &mut record);
            fleet.insert(id, record, saved, None);
        }
        saving::start(&fleet, save_every);
        keeping::start(&fleet);
        fleet
    }
}
