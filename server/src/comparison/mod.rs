//! Comparisons of methods: what they are among the jobs of the server.

pub(crate) mod report;
