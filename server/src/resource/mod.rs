//! What every resource of the server has: a version, a condition under which it is written, changes that run to their
//! end, and what goes wrong with it.
//!
//! Architecture invariant: nothing here knows a kind of resource, the store, or HTTP but for the contract's codes.

pub(crate) mod change;
pub(crate) mod condition;
pub(crate) mod etag;
pub(crate) mod failure;
