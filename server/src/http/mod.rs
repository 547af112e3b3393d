//! The server as HTTP has it: who may ask, what is read, what is answered, and what one peer may use.

pub(crate) mod answer;
pub(crate) mod app;
pub(crate) mod budget;
pub(crate) mod condition;
pub(crate) mod connection;
mod deadline;
mod documents;
pub(crate) mod etag;
mod extract;
pub(crate) mod failure;
mod frames;
pub(crate) mod guard;
pub(crate) mod router;
mod routes;
