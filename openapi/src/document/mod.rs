//! The contract as OpenAPI 3.1.
//!
//! Made of the table of [endpoints](crate::endpoint) rather than from annotated functions: this crate has no functions to
//! annotate, and what the document says is what the server's router and the client go by. Limits come from the checks.

mod examples;
mod failures;
mod limits;
mod operation;
mod requests;
mod variants;

use crate::endpoint::{self, Schemas};
use utoipa::openapi::security::{HttpAuthScheme, HttpBuilder, SecurityRequirement, SecurityScheme};
use utoipa::openapi::{ComponentsBuilder, InfoBuilder, LicenseBuilder, OpenApi, OpenApiBuilder};
use utoipa::openapi::{PathsBuilder, RefOr, Schema, ServerBuilder, tag::TagBuilder};

const ABOUT: &str = "Controller server for two-wheel robots over bad links: poses in, wheel speeds out, and what \
is identified of the floor and the link.\n\nJSON in snake_case; every quantity names its unit (`x_m`, \
`heading_rad`, `left_rad_per_s`). Times that end in `_s` and mark a moment are the robot's own monotonic clock. \
Unknown fields are refused in requests and must be ignored in responses: the contract only grows, and a type that \
goes both ways has a schema for each. Lists are never taken for objects; whole numbers may be written as 20.0. Every \
problem of a request is reported at once: 400 where a schema says no, 409 where all schemas say yes and the state, the \
names that there are, or another field of the same body says no. Only UNAVAILABLE is retried by itself.";

const LICENSE: &str = "MIT OR Apache-2.0";

/// How a request shows that it may, to a server that has a token.
const BEARER: &str = "bearer";

const TAGS: [(&str, &str); 10] = [
    ("robots", "A robot: drive, limits, noise, method, prior; and how it is now"),
    ("tasks", "Where a robot is to go, and how far it has got"),
    ("control", "The hot path, and the stop"),
    ("environments", "What is identified of the floor and the link"),
    ("priors", "What robots are told to believe before any sample, by name"),
    ("training", "Simulated environments by name: floors and links on which priors are evolved"),
    ("evolutions", "Priors searched for in the background"),
    ("comparisons", "Methods compared in the background: the same seeds for all"),
    ("events", "What happens, as server-sent events"),
    ("server", "The server itself"),
];

/// The contract, all operations and schemas; checked in as `openapi/openapi.json`.
///
/// ```
/// let document = umwelt_api::document();
/// assert!(document.paths.paths.contains_key("/v1/robots/{robot}/step"));
/// ```
pub fn document() -> OpenApi {
    let (mut paths, mut schemas) = (PathsBuilder::new(), Schemas::default());
    for operation in endpoint::all() {
        paths = paths.path(operation.path, operation::item(operation, &mut schemas));
    }
    let responses = failures::responses(&mut schemas);
    limits::apply(&mut schemas);
    variants::name(&mut schemas);
    schemas.values_mut().for_each(without_examples);
    let tags =
        TAGS.map(|(name, about)| TagBuilder::new().name(name).description(Some(about)).build());
    let license = LicenseBuilder::new().name(LICENSE).identifier(Some(LICENSE)).build();
    let info = InfoBuilder::new()
        .title("Umwelt")
        .version("1")
        .description(Some(ABOUT))
        .license(Some(license))
        .build();
    let server = ServerBuilder::new()
        .url("http://127.0.0.1:8080")
        .description(Some("The server on this machine, where it listens by default"))
        .build();
    // Without a token where the server has none.
    let bearer = SecurityRequirement::new::<_, [&str; 0], &str>(BEARER, []);
    let scheme = SecurityScheme::Http(HttpBuilder::new().scheme(HttpAuthScheme::Bearer).build());
    let components = ComponentsBuilder::new()
        .schemas_from_iter(schemas)
        .responses_from_iter(responses)
        .security_scheme(BEARER, scheme);
    let mut document = OpenApiBuilder::new()
        .info(info)
        .servers(Some([server]))
        .paths(paths.build())
        .components(Some(components.build()))
        .security(Some([SecurityRequirement::default(), bearer]))
        .tags(Some(tags))
        .build();
    requests::close(&mut document);
    document
}

/// Cuts the Rust examples off the description of a schema: the words before them are for every reader.
fn without_examples(schema: &mut RefOr<Schema>) {
    let description = match schema {
        RefOr::T(Schema::Object(object)) => &mut object.description,
        RefOr::T(Schema::AllOf(all_of)) => &mut all_of.description,
        RefOr::T(Schema::OneOf(one_of)) => &mut one_of.description,
        _ => return,
    };
    if let Some(text) = description {
        text.truncate(text.find("\n\n```").unwrap_or(text.len()));
    }
}
