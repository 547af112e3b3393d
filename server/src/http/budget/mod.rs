//! Budgets: what one peer may use of the server, and what all of them may use together.
//!
//! Each budget has two limits, overall and per peer, and the one per peer lies below the other, so that no peer alone
//! uses up what others need. Who is at a limit gets more by ending what is of least use: the connection that has been
//! idle the longest, the body that has been arriving the longest, each of the peer that holds most.
//!
//! Invariants: what is given is given back when its guard is dropped; a peer is never refused for the sake of one that
//! holds more; nothing here waits.

mod bodies;
mod connections;
mod files;
mod ledger;
mod peer;
mod reserve;
mod streams;

pub(crate) use bodies::{Bodies, Unread};
pub(crate) use connections::{Connections, Place};
pub(crate) use files::allow_files;
pub(crate) use ledger::Limits;
pub(crate) use peer::Peer;
pub(crate) use reserve::reserved;
pub(crate) use streams::{Stream, Streams};
