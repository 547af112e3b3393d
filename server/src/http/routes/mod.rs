//! What the routes do, one file per resource.

pub(crate) mod control;
pub(crate) mod environment;
pub(crate) mod environments;
pub(crate) mod events;
pub(crate) mod jobs;
pub(crate) mod page;
pub(crate) mod priors;
pub(crate) mod robots;
pub(crate) mod server;
pub(crate) mod tasks;
