//! The server as HTTP has it: who may ask, what is read, what is answered, and what one peer may use.

pub(crate) mod acceptor;
pub(crate) mod answer;
pub(crate) mod app;
pub(crate) mod budget;
mod condition;
pub(crate) mod connection;
pub(crate) mod deadline;
pub(crate) mod documents;
mod extract;
mod frames;
pub(crate) mod guard;
pub(crate) mod router;
mod routes;
