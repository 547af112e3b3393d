//! What happens, for those who follow it: a bounded ring of events per robot, and one of all robots.
//!
//! Followers pull: each has its own place and reads from the ring when its connection takes more. So a slow
//! follower costs nothing and blocks no one; when the ring has run over its place, it is told that it missed some.
//! An event is written when the first of them reads it, and once for all of them.

mod entry;

pub(crate) use entry::{Entry, What};

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{SystemTime, UNIX_EPOCH};
use tokio::sync::watch;
use umwelt_api::RobotId;
use umwelt_api::event::Kind;

/// Events kept per robot: ten seconds of a driving robot.
const KEPT_OF_ROBOT: usize = 256;

/// Events kept of all robots together: ten seconds of thirty driving robots, some 4 MB.
const KEPT_OF_ALL: usize = 8192;

/// Most events that a follower takes at a time: some 50 kB.
pub(crate) const BATCH: usize = 32;

/// Numbers events and keeps the last of them.
#[derive(Clone, Debug)]
pub(crate) struct Feed(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    /// The id of the newest event. Held while an event is put into its rings, so that their order is one.
    newest: Mutex<u64>,
    all: Arc<Ring>,
}

impl Feed {
    /// A feed whose ids go on above those of an earlier run of the server, so that a follower of then is not
    /// taken for one of now: they begin at the microseconds since 1970.
    pub(crate) fn new() -> Self {
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        Self::beginning_at(u64::try_from(since.as_micros()).unwrap_or(1))
    }

    fn beginning_at(id: u64) -> Self {
        let all = Arc::new(Ring::new(KEPT_OF_ALL, id));
        Self(Arc::new(Inner { newest: Mutex::new(id), all }))
    }

    /// The events of all robots.
    pub(crate) fn all(&self) -> &Arc<Ring> {
        &self.0.all
    }

    /// A ring for the events of one robot.
    pub(crate) fn ring(&self) -> Arc<Ring> {
        Arc::new(Ring::new(KEPT_OF_ROBOT, *self.newest()))
    }

    /// Something happened to `robot`, whose ring is `ring`.
    pub(crate) fn publish(&self, ring: &Ring, robot: &RobotId, what: impl Into<What>) {
        let mut newest = self.newest();
        *newest += 1;
        let event = Arc::new(Entry::new(*newest, Some(robot.clone()), what.into()));
        ring.push(Arc::clone(&event));
        self.0.all.push(event);
    }

    fn newest(&self) -> MutexGuard<'_, u64> {
        self.0.newest.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The last events, oldest first.
#[derive(Debug)]
pub(crate) struct Ring {
    capacity: usize,
    kept: Mutex<Kept>,
    /// Wakes followers.
    changed: watch::Sender<()>,
}

#[derive(Debug)]
struct Kept {
    events: VecDeque<Arc<Entry>>,
    /// The id up to which events are forgotten.
    forgotten: u64,
    is_closed: bool,
}

impl Ring {
    fn new(capacity: usize, forgotten: u64) -> Self {
        let kept = Kept { events: VecDeque::new(), forgotten, is_closed: false };
        Self { capacity, kept: Mutex::new(kept), changed: watch::Sender::new(()) }
    }

    fn push(&self, event: Arc<Entry>) {
        let mut kept = self.kept();
        if kept.events.len() == self.capacity
            && let Some(oldest) = kept.events.pop_front()
        {
            kept.forgotten = oldest.id();
        }
        kept.events.push_back(event);
        drop(kept);
        self.changed.send_replace(());
    }

    /// Nothing will happen any more: followers end once they have seen what there is.
    pub(crate) fn close(&self) {
        self.kept().is_closed = true;
        self.changed.send_replace(());
    }

    /// Follows the events behind the one with id `after`; those from now on where none is named.
    pub(crate) fn follow(self: &Arc<Self>, after: Option<u64>) -> Follower {
        let kept = self.kept();
        let newest = kept.events.back().map_or(kept.forgotten, |event| event.id());
        // An id above the newest is from another life of the server: whatever happened since is missed.
        let place = after.map_or(newest, |id| if id <= newest { id } else { 0 });
        drop(kept);
        Follower { place, changed: self.changed.subscribe(), ring: Arc::clone(self) }
    }

    fn kept(&self) -> MutexGuard<'_, Kept> {
        // No call panics between two changes, so a poisoned ring is whole.
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// One reader of a ring, with its place in it.
#[derive(Debug)]
pub(crate) struct Follower {
    ring: Arc<Ring>,
    /// The id of the last event read.
    place: u64,
    changed: watch::Receiver<()>,
}

impl Follower {
    /// The next events, as soon as there are some, and no more than [`BATCH`]; none when there will be no more.
    pub(crate) async fn next(&mut self) -> Option<Vec<Arc<Entry>>> {
        loop {
            self.changed.mark_unchanged();
            if let Some(events) = self.ready() {
                return Some(events);
            }
            if self.ring.kept().is_closed {
                // What was published before the end is read before the end.
                return self.ready();
            }
            self.changed.changed().await.ok()?;
        }
    }

    fn ready(&mut self) -> Option<Vec<Arc<Entry>>> {
        let kept = self.ring.kept();
        let missed = (self.place < kept.forgotten)
            .then(|| Arc::new(Entry::new(kept.forgotten, None, Kind::Missed.into())));
        let place = self.place.max(kept.forgotten);
        let behind = kept.events.partition_point(|event| event.id() <= place);
        let events = kept.events.range(behind..).cloned();
        let events: Vec<_> = missed.into_iter().chain(events).take(BATCH).collect();
        drop(kept);
        self.place = events.last()?.id();
        Some(events)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use futures_util::FutureExt;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use umwelt_api::event::Event;

    const BEGIN: u64 = 1000;

    fn feed() -> (Feed, Arc<Ring>, RobotId) {
        let feed = Feed::beginning_at(BEGIN);
        let ring = feed.ring();
        (feed, ring, "rover-7".parse().unwrap())
    }

    /// What a follower gets without waiting.
    fn ready(follower: &mut Follower) -> Vec<Event> {
        let batches = std::iter::from_fn(|| follower.next().now_or_never().flatten());
        batches.flatten().map(|entry| entry.event()).collect()
    }

    fn ids(follower: &mut Follower) -> Vec<u64> {
        ready(follower).iter().map(|event| event.id).collect()
    }

    #[test]
    fn a_follower_sees_what_comes_after_it_began_each_once_and_in_order() {
        let (feed, ring, robot) = feed();
        feed.publish(&ring, &robot, Kind::Registered);
        let mut follower = ring.follow(None);
        assert!(ids(&mut follower).is_empty());
        feed.publish(&ring, &robot, Kind::Stopped);
        feed.publish(&ring, &robot, Kind::Resumed);
        assert_eq!(ids(&mut follower), [BEGIN + 2, BEGIN + 3]);
        assert!(ids(&mut follower).is_empty());
    }

    #[test]
    fn it_resumes_behind_an_id_without_a_gap_and_without_a_repeat() {
        let (feed, ring, robot) = feed();
        let other = feed.ring();
        for _ in 0..4 {
            feed.publish(&ring, &robot, Kind::Stopped);
            feed.publish(&other, &robot, Kind::Resumed);
        }
        assert_eq!(ids(&mut ring.follow(Some(BEGIN + 3))), [BEGIN + 5, BEGIN + 7]);
        assert_eq!(ids(&mut feed.all().follow(Some(BEGIN + 6))), [BEGIN + 7, BEGIN + 8]);
    }

    /// Guards against: a slow follower goes on as if nothing had happened, or holds up the robot.
    #[test]
    fn one_that_is_too_slow_is_told_what_it_missed_and_goes_on() {
        let (feed, ring, robot) = feed();
        let mut follower = ring.follow(None);
        for _ in 0..KEPT_OF_ROBOT + 10 {
            feed.publish(&ring, &robot, Kind::Stopped);
        }
        let events = ready(&mut follower);
        assert_eq!(events[0].kind, Kind::Missed);
        assert_eq!(events[0].id, BEGIN + 10, "resuming behind it misses nothing more");
        assert_eq!(events[1].id, BEGIN + 11);
        assert_eq!(events.len(), KEPT_OF_ROBOT + 1);
        assert!(ring.kept().events.len() <= KEPT_OF_ROBOT);
    }

    #[test]
    fn ids_of_another_life_of_the_server_are_missed_events() {
        let (feed, ring, robot) = feed();
        feed.publish(&ring, &robot, Kind::Stopped);
        for foreign in [0, BEGIN - 1, BEGIN + 2, u64::MAX] {
            let events = ready(&mut ring.follow(Some(foreign)));
            assert_eq!(events[0].kind, Kind::Missed, "{foreign}");
            assert_eq!(events[1].id, BEGIN + 1, "{foreign}");
        }
    }

    #[test]
    fn a_closed_ring_is_read_to_its_end() {
        let (feed, ring, robot) = feed();
        let mut follower = ring.follow(None);
        feed.publish(&ring, &robot, Kind::Removed);
        ring.close();
        assert_eq!(ready(&mut follower)[0].kind, Kind::Removed);
        assert!(matches!(follower.next().now_or_never(), Some(None)), "it ends rather than waits");
    }

    /// Guards against: an event that costs as much as there are followers, or something when no one follows.
    #[test]
    fn an_event_is_made_and_written_once_for_all_and_not_at_all_for_no_one() {
        let (feed, ring, robot) = feed();
        let made = Arc::new(AtomicUsize::new(0));
        let count = Arc::clone(&made);
        let ask = move || {
            count.fetch_add(1, Ordering::Relaxed);
            Kind::Stopped
        };
        let mut followers = [ring.follow(None), ring.follow(None), feed.all().follow(None)];
        feed.publish(&ring, &robot, What::Asked(Box::new(ask)));
        assert_eq!(made.load(Ordering::Relaxed), 0);
        let written = followers.each_mut().map(|follower| {
            let entries = follower.next().now_or_never().flatten().unwrap();
            entries[0].written().clone()
        });
        assert_eq!(made.load(Ordering::Relaxed), 1);
        assert!(written[0].starts_with(b"id: 1001\nevent: stopped\ndata: {"), "{written:?}");
        let at = written.each_ref().map(|bytes| bytes.as_ptr());
        assert_eq!(at, [at[0]; 3], "the same bytes, not copies of them");
    }

    #[test]
    fn a_follower_takes_what_there_is_at_once_but_not_without_a_bound() {
        let (feed, ring, robot) = feed();
        let mut follower = ring.follow(None);
        for _ in 0..2 * BATCH + 1 {
            feed.publish(&ring, &robot, Kind::Stopped);
        }
        let mut sizes = Vec::new();
        while let Some(Some(events)) = follower.next().now_or_never() {
            sizes.push(events.len());
        }
        assert_eq!(sizes, [BATCH, BATCH, 1]);
    }
}
