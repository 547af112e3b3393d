//! Whether the server lives and takes requests.

use crate::schema::ToSchema;
use serde::{Deserialize, Serialize};

/// The server answers: `/healthz` while it lives, `/readyz` while it takes requests (503 otherwise).
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = Health)]
pub struct Health {
    /// Always `ok`; anything else is an error.
    pub status: String,
    /// Version of the server.
    pub version: String,
}

impl Health {
    /// The server of `version` is well.
    pub fn ok(version: impl Into<String>) -> Self {
        Self { status: "ok".to_owned(), version: version.into() }
    }
}
