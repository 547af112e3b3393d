//! The server itself.

use super::{Answer, Endpoint, Operation, Scope, get};
use crate::health;

endpoints! {
    /// Whether the server lives
    HEALTH: Endpoint<(), health::Health> = get("health", "/healthz")
        .tag("server")
        .scope(Scope::Open)
        .gives(&[(200, "It does")]);
    /// Whether the server takes requests
    READINESS: Endpoint<(), health::Health> = get("readiness", "/readyz")
        .tag("server")
        .gives(&[(200, "It does")])
        .fails(&[503]);
    /// This document
    CONTRACT: Endpoint = get("contract", "/openapi.json")
        .tag("server")
        .answers(Answer::Object("OpenAPI 3.1"));
}
