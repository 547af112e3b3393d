//! What the routes do, one file per resource.

pub(crate) mod control;
pub(crate) mod environment;
pub(crate) mod events;
pub(crate) mod page;
pub(crate) mod robots;
pub(crate) mod server;
pub(crate) mod tasks;
