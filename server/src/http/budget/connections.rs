//! Places for connections: one per connection, and at the limit the longest idle one gives way.

use super::ledger::{Account, Holding, Ledger};
use super::{Limits, Peer};
use hyper::body::Body;
use std::pin::Pin;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll};
use std::time::Duration;
use tokio::sync::Notify;
use tokio::time::Instant;

/// A connection that has brought more requests than this is in use, and gives way after those that are not: the one of
/// a robot that was silent for a while is worth more than one that was only opened.
const FEW: usize = 8;

/// Places for connections; cheap to clone.
#[derive(Clone, Debug)]
pub(crate) struct Connections(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    ledger: Mutex<Ledger<Arc<Activity>>>,
    /// How long one must have been idle before it can be made to give way.
    idle: Duration,
}

/// What a connection is doing.
#[derive(Debug)]
pub(crate) struct Activity {
    /// Requests that are not answered in full.
    requests: AtomicUsize,
    /// Requests that have been answered.
    answered: AtomicUsize,
    born: Instant,
    /// Milliseconds after `born` at which the last request was answered.
    idle_since: AtomicU64,
    evicted: Notify,
}

/// The place of one connection; free when this is dropped.
#[derive(Debug)]
pub(crate) struct Place {
    connections: Connections,
    peer: Peer,
    id: u64,
    activity: Arc<Activity>,
}

/// While this lives, a request is being answered.
#[derive(Debug)]
struct Busy(Arc<Activity>);

impl Connections {
    /// So many places. A connection without a request for `idle` gives its place to a new one where there is none left.
    pub(crate) fn new(limits: Limits, idle: Duration) -> Self {
        Self(Arc::new(Inner { ledger: Mutex::new(Ledger::new(limits)), idle }))
    }

    /// A place for one more connection of a peer. None where each connection in the way is busy.
    pub(crate) fn admit(&self, peer: Peer) -> Option<Place> {
        let mut ledger = self.ledger();
        while let Some(scope) = ledger.exceeded(peer, 1) {
            ledger.evict(peer, scope, |account| self.longest_idle(account))?.evicted.notify_one();
        }
        let activity = Arc::new(Activity::new());
        let id = ledger.join(peer, 1, Arc::clone(&activity));
        drop(ledger);
        Some(Place { connections: self.clone(), peer, id, activity })
    }

    fn longest_idle(&self, account: &Account<Arc<Activity>>) -> Option<u64> {
        let idle = |(id, held): (&u64, &Holding<Arc<Activity>>)| {
            let idle = held.holder.idle()?;
            let rank = (!held.holder.is_in_use(), idle);
            (idle >= self.0.idle).then_some((rank, *id))
        };
        // Of those that have been idle equally long the first that came.
        let longest = account
            .holders
            .iter()
            .filter_map(idle)
            .reduce(|longest, next| if next.0 > longest.0 { next } else { longest });
        longest.map(|(_, id)| id)
    }

    fn ledger(&self) -> MutexGuard<'_, Ledger<Arc<Activity>>> {
        // No call panics between two changes, so a poisoned ledger is whole.
        self.0.ledger.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Place {
    /// Whose it is.
    pub(crate) fn peer(&self) -> Peer {
        self.peer
    }

    /// What the connection does.
    pub(crate) fn activity(&self) -> &Arc<Activity> {
        &self.activity
    }

    /// Returns when the connection is to give way.
    pub(crate) async fn evicted(&self) {
        self.activity.evicted.notified().await;
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.connections.ledger().leave(self.peer, self.id);
    }
}

impl Activity {
    fn new() -> Self {
        Self {
            requests: AtomicUsize::new(0),
            answered: AtomicUsize::new(0),
            born: Instant::now(),
            idle_since: AtomicU64::new(0),
            evicted: Notify::new(),
        }
    }

    /// `body`, as long as which lives the connection counts as busy.
    pub(crate) fn tracked<B>(self: &Arc<Self>) -> impl FnOnce(B) -> Tracked<B> + use<B> {
        self.requests.fetch_add(1, Ordering::Relaxed);
        let busy = Busy(Arc::clone(self));
        move |body| Tracked { body, _busy: busy }
    }

    /// Whether someone uses it for more than a few requests, as an agent does.
    fn is_in_use(&self) -> bool {
        self.answered.load(Ordering::Relaxed) > FEW
    }

    /// For how long there has been no request; none while there is one.
    fn idle(&self) -> Option<Duration> {
        let is_idle = self.requests.load(Ordering::Relaxed) == 0;
        let since = Duration::from_millis(self.idle_since.load(Ordering::Relaxed));
        is_idle.then(|| self.born.elapsed().saturating_sub(since))
    }
}

impl Drop for Busy {
    fn drop(&mut self) {
        let now = u64::try_from(self.0.born.elapsed().as_millis()).unwrap_or(u64::MAX);
        self.0.idle_since.store(now, Ordering::Relaxed);
        self.0.answered.fetch_add(1, Ordering::Relaxed);
        self.0.requests.fetch_sub(1, Ordering::Relaxed);
    }
}

/// The body of a response, as long as which lives its connection counts as busy.
#[derive(Debug)]
pub(crate) struct Tracked<B> {
    body: B,
    _busy: Busy,
}

impl<B: Body + Unpin> Body for Tracked<B> {
    type Data = B::Data;
    type Error = B::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<hyper::body::Frame<B::Data>, B::Error>>> {
        Pin::new(&mut self.body).poll_frame(context)
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> hyper::body::SizeHint {
        self.body.size_hint()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use futures_util::FutureExt;

    const IDLE: Duration = Duration::from_secs(1);

    fn peer(number: u8) -> Peer {
        Peer::of([192, 0, 2, number].into())
    }

    fn connections(overall: usize, per_peer: usize) -> Connections {
        Connections::new(Limits { overall, per_peer }, IDLE)
    }

    fn is_evicted(place: &Place) -> bool {
        place.evicted().now_or_never().is_some()
    }

    #[tokio::test(start_paused = true)]
    async fn a_peer_at_its_limit_leaves_room_for_others() {
        let connections = connections(4, 3);
        let held: Vec<_> = (0..3).map(|_| connections.admit(peer(1)).unwrap()).collect();
        assert!(connections.admit(peer(1)).is_none());
        let other = connections.admit(peer(2)).unwrap();
        assert!(connections.admit(peer(2)).is_none(), "all are taken, and none is idle for long");
        assert!(held.iter().chain([&other]).all(|place| !is_evicted(place)));
        drop(held);
        assert!(connections.admit(peer(1)).is_some(), "what is dropped is free");
    }

    #[tokio::test(start_paused = true)]
    async fn the_longest_idle_of_the_greediest_gives_way_and_a_busy_one_never() {
        let connections = connections(4, 3);
        let greedy: Vec<_> = (0..3).map(|_| connections.admit(peer(1)).unwrap()).collect();
        let _modest = connections.admit(peer(2)).unwrap();
        let answer = greedy[0].activity().tracked()(());
        tokio::time::advance(IDLE / 2).await;
        // One request that has been answered: it has not been idle for as long as the third.
        drop(greedy[1].activity().tracked()(()));
        assert!(connections.admit(peer(3)).is_none(), "none has been idle for long enough");
        tokio::time::advance(IDLE).await;
        let _third = connections.admit(peer(3)).unwrap();
        assert_eq!(greedy.iter().map(is_evicted).collect::<Vec<_>>(), [false, false, true]);
        let _fourth = connections.admit(peer(4)).unwrap();
        assert_eq!(greedy.iter().map(is_evicted).collect::<Vec<_>>(), [false, true, false]);
        // What is left is busy, or of one who holds no more.
        assert!(connections.admit(peer(3)).is_none());
        drop(answer);
        tokio::time::advance(IDLE / 2).await;
        assert!(connections.admit(peer(5)).is_some(), "somebody with one place for one with none");
    }

    /// Guards against: robots that were silent for a moment lose their connections to someone who only opens some.
    #[tokio::test(start_paused = true)]
    async fn a_connection_in_use_gives_way_after_those_that_were_only_opened() {
        let connections = connections(3, 3);
        let robot = connections.admit(peer(1)).unwrap();
        for _ in 0..=FEW {
            drop(robot.activity().tracked()(()));
        }
        tokio::time::advance(IDLE).await;
        let opened: Vec<_> = (0..2).map(|_| connections.admit(peer(1)).unwrap()).collect();
        tokio::time::advance(IDLE).await;
        let _new: Vec<_> = (0..2).map(|_| connections.admit(peer(1)).unwrap()).collect();
        assert!(opened.iter().all(is_evicted) && !is_evicted(&robot));
        let _last = connections.admit(peer(1)).unwrap();
        assert!(is_evicted(&robot), "where there is no other");
    }

    /// Guards against: a place that is given back twice, by who had to give way and by who ends.
    #[tokio::test(start_paused = true)]
    async fn who_gave_way_gives_nothing_back_at_its_end() {
        let connections = connections(2, 2);
        let first = connections.admit(peer(1)).unwrap();
        let _second = connections.admit(peer(1)).unwrap();
        tokio::time::advance(IDLE).await;
        let _third = connections.admit(peer(2)).unwrap();
        drop(first);
        assert_eq!(connections.ledger().held(), 2);
    }
}
