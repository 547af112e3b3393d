//! Bytes of bodies in flight: of requests that are still arriving or being answered.

use super::ledger::{Account, Ledger};
use super::{Limits, Peer};
use axum::body::Body;
use bytes::Bytes;
use http_body_util::BodyExt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::Notify;

/// What a body costs beside its bytes: the request's head, its task and its stream, roughly. It bounds the number of
/// bodies that have hardly begun.
const OVERHEAD: usize = 1024;

/// A buffer begins with room for this much: nearly every step fits.
const FIRST_ROOM: usize = 2048;

/// A budget of bytes; cheap to clone.
#[derive(Clone, Debug)]
pub(crate) struct Bodies(Arc<Mutex<Ledger<Arc<Notify>>>>);

/// Why there is no body.
#[derive(Debug)]
pub(crate) enum Unread {
    /// It has more bytes than it may have.
    TooLarge,
    /// It ended early, and how.
    Broken(axum::Error),
    /// The budget with these limits is used up, and this body had been arriving the longest, or nothing could be given
    /// up for it.
    GivenUp(Limits),
}

/// What a body has of the budget, until this is dropped.
#[derive(Debug)]
struct Share {
    bodies: Bodies,
    peer: Peer,
    state: State,
}

#[derive(Debug)]
enum State {
    /// It can be given up in favour of another one.
    Arriving(u64),
    /// It is here, with so many bytes.
    Here(usize),
}

/// A body with its share.
struct Held {
    bytes: Content,
    _share: Share,
}

/// In one piece as it came, or put together.
enum Content {
    Piece(Bytes),
    Whole(Vec<u8>),
}

impl AsRef<[u8]> for Held {
    fn as_ref(&self) -> &[u8] {
        match &self.bytes {
            Content::Piece(bytes) => bytes,
            Content::Whole(bytes) => bytes,
        }
    }
}

impl Bodies {
    /// So many bytes.
    pub(crate) fn new(limits: Limits) -> Self {
        Self(Arc::new(Mutex::new(Ledger::new(limits))))
    }

    /// Reads a body of at most `limit` bytes to its end. What it has of the budget is given back when the last clone of
    /// it is dropped.
    ///
    /// # Errors
    /// Where there is none in full.
    pub(crate) async fn read(&self, peer: Peer, body: Body, limit: usize) -> Result<Bytes, Unread> {
        let given_up = Arc::new(Notify::new());
        let share = self.open(peer, Arc::clone(&given_up))?;
        tokio::select! {
            biased;
            () = given_up.notified() => Err(Unread::GivenUp(self.ledger().limits())),
            read = collect(body, limit, share) => read,
        }
    }

    fn open(&self, peer: Peer, given_up: Arc<Notify>) -> Result<Share, Unread> {
        let mut ledger = self.ledger();
        self.make_room(&mut ledger, peer, None, OVERHEAD)?;
        let id = ledger.join(peer, OVERHEAD, given_up);
        drop(ledger);
        Ok(Share { bodies: self.clone(), peer, state: State::Arriving(id) })
    }

    /// Gives up the oldest bodies until there is room for so many more bytes of the one with `id`, but not that one.
    fn make_room(
        &self,
        ledger: &mut Ledger<Arc<Notify>>,
        peer: Peer,
        id: Option<u64>,
        more: usize,
    ) -> Result<(), Unread> {
        let oldest_other = |account: &Account<Arc<Notify>>| {
            account.holders.keys().find(|other| Some(**other) != id).copied()
        };
        while let Some(scope) = ledger.exceeded(peer, more) {
            let oldest = ledger.evict(peer, scope, oldest_other);
            oldest.ok_or(Unread::GivenUp(ledger.limits()))?.notify_one();
        }
        Ok(())
    }

    fn ledger(&self) -> MutexGuard<'_, Ledger<Arc<Notify>>> {
        // No call panics between two changes, so a poisoned ledger is whole.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Share {
    /// Takes so many more bytes.
    fn grow(&self, more: usize) -> Result<(), Unread> {
        let State::Arriving(id) = self.state else { return Ok(()) };
        let mut ledger = self.bodies.ledger();
        self.bodies.make_room(&mut ledger, self.peer, Some(id), more)?;
        let is_held = ledger.grow(self.peer, id, more);
        if is_held { Ok(()) } else { Err(Unread::GivenUp(ledger.limits())) }
    }

    /// The body is here: it is not given up any more.
    fn settle(mut self) -> Result<Self, Unread> {
        let State::Arriving(id) = self.state else { return Ok(self) };
        let mut ledger = self.bodies.ledger();
        let settled = ledger.settle(self.peer, id);
        let limits = ledger.limits();
        drop(ledger);
        let bytes = settled.ok_or(Unread::GivenUp(limits))?;
        self.state = State::Here(bytes);
        Ok(self)
    }
}

impl Drop for Share {
    fn drop(&mut self) {
        let mut ledger = self.bodies.ledger();
        match self.state {
            State::Arriving(id) => drop(ledger.leave(self.peer, id)),
            State::Here(bytes) => ledger.give(self.peer, bytes),
        }
    }
}

/// All bytes of a body. Its frames are copied together, since each may keep a larger buffer alive.
async fn collect(mut body: Body, limit: usize, share: Share) -> Result<Bytes, Unread> {
    let mut whole = Vec::new();
    while let Some(frame) = body.frame().await {
        // Many small frames that are there already do not keep others waiting.
        tokio::task::coop::consume_budget().await;
        let Ok(piece) = frame.map_err(Unread::Broken)?.into_data() else { continue };
        if whole.len() + piece.len() > limit {
            return Err(Unread::TooLarge);
        }
        if whole.is_empty() && axum::body::HttpBody::is_end_stream(&body) {
            share.grow(piece.len())?;
            return held(Content::Piece(piece), share);
        }
        reserve(&mut whole, piece.len(), limit, &share)?;
        whole.extend_from_slice(&piece);
    }
    held(Content::Whole(whole), share)
}

/// Makes room in a buffer, for which the share pays.
fn reserve(buffer: &mut Vec<u8>, more: usize, limit: usize, share: &Share) -> Result<(), Unread> {
    let needed = buffer.len() + more;
    if needed > buffer.capacity() {
        let room = needed.max(2 * buffer.capacity()).max(FIRST_ROOM).min(limit.max(needed));
        share.grow(room - buffer.capacity())?;
        buffer.reserve_exact(room - buffer.len());
    }
    Ok(())
}

fn held(bytes: Content, share: Share) -> Result<Bytes, Unread> {
    Ok(Bytes::from_owner(Held { bytes, _share: share.settle()? }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use futures_util::{FutureExt, StreamExt, stream};
    use std::convert::Infallible;
    use std::future::Future;
    use std::pin::Pin;

    type Reading = Pin<Box<dyn Future<Output = Result<Bytes, Unread>> + Send>>;

    const KB: usize = 1024;

    fn peer(number: u8) -> Peer {
        Peer::of([192, 0, 2, number].into())
    }

    fn bodies(overall: usize, per_peer: usize) -> Bodies {
        Bodies::new(Limits { overall, per_peer })
    }

    /// So many bytes, and then nothing more for ever.
    fn unfinished(bytes: usize) -> Body {
        let pieces = stream::iter([Ok::<_, Infallible>(vec![b' '; bytes])]);
        Body::from_stream(pieces.chain(stream::pending()))
    }

    fn reading(bodies: &Bodies, peer: Peer, body: Body) -> Reading {
        let bodies = bodies.clone();
        Box::pin(async move { bodies.read(peer, body, 64 * KB).await })
    }

    fn is_given_up(reading: &mut Reading) -> bool {
        matches!(reading.now_or_never(), Some(Err(Unread::GivenUp(_))))
    }

    /// Guards against: bodies that never end hold memory without a bound, or keep out those that are whole.
    #[tokio::test]
    async fn unfinished_bodies_are_bounded_and_the_oldest_make_room_for_new_ones() {
        let bodies = bodies(64 * KB, 40 * KB);
        let held = |of: u8| bodies.ledger().held_by(peer(of));
        let mut greedy: Vec<_> =
            (0..100).map(|_| reading(&bodies, peer(1), unfinished(9 * KB))).collect();
        for reading in &mut greedy {
            let _ = reading.now_or_never();
            assert!(held(1) <= 40 * KB, "{}", held(1));
        }
        let over: Vec<_> = greedy[..96].iter_mut().map(is_given_up).collect();
        assert!(over.iter().all(|is_over| *is_over), "{over:?}");
        assert!(
            greedy[97..].iter_mut().all(|reading| reading.now_or_never().is_none()),
            "the newest go on"
        );
        // A whole body of the same peer is read all the same, and one of another peer costs no one anything.
        let whole = Body::from(vec![b'1'; 8 * KB]);
        assert_eq!(reading(&bodies, peer(1), whole).await.unwrap().len(), 8 * KB);
        let before = held(1);
        let other = reading(&bodies, peer(2), Body::from(vec![b'2'; 20 * KB])).await.unwrap();
        assert_eq!((held(1), held(2)), (before, 20 * KB + OVERHEAD));
        drop((greedy, other));
        let ledger = bodies.ledger();
        assert_eq!((ledger.held(), ledger.peers()), (0, 0), "all of it comes back");
    }

    #[tokio::test]
    async fn a_body_that_is_here_is_kept_and_counted_until_it_has_been_answered() {
        let bodies = bodies(8 * KB, 8 * KB);
        let first = reading(&bodies, peer(1), Body::from(vec![b'1'; 4 * KB])).await.unwrap();
        let second = reading(&bodies, peer(1), Body::from(vec![b'2'; 4 * KB])).await;
        assert!(matches!(second, Err(Unread::GivenUp(_))), "{second:?}");
        assert_eq!(first, vec![b'1'; 4 * KB]);
        drop(first);
        assert!(reading(&bodies, peer(1), Body::from(vec![b'2'; 4 * KB])).await.is_ok());
    }

    #[tokio::test]
    async fn a_body_is_put_together_from_any_pieces_and_is_never_too_large() {
        let bodies = bodies(1 << 20, 1 << 20);
        let text: Vec<u8> = (0..=255).cycle().take(10_000).collect();
        for piece in [1, 7, 4096, 10_000] {
            let pieces: Vec<_> =
                text.chunks(piece).map(|it| Ok::<_, Infallible>(it.to_vec())).collect();
            let read =
                bodies.read(peer(1), Body::from_stream(stream::iter(pieces.clone())), 10_000).await;
            assert_eq!(read.unwrap(), text);
            let read = bodies.read(peer(1), Body::from_stream(stream::iter(pieces)), 9_999).await;
            assert!(matches!(read, Err(Unread::TooLarge)));
        }
        assert_eq!(bodies.read(peer(1), Body::empty(), 10).await.unwrap(), "");
        assert_eq!(bodies.ledger().held(), 0);
    }
}
