//! What is made of evolutions and comparisons: figures, tables, reports; and both of them without a server.

pub(crate) mod csv;
pub(crate) mod figures;
pub mod offline;
pub(crate) mod report;
