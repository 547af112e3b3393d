//! The contract as OpenAPI 3.1.
//!
//! Built from a table of routes rather than from annotated functions: this crate has no functions to annotate, and
//! a route's path parameters come from its template, so the two cannot part. Limits come from the checks.

mod compare;
mod evolve;
mod limits;
mod requests;
mod route;

use crate::robot::{self, DEFAULT_PAGE_SIZE, MAX_PAGE_SIZE};
use crate::{environment, event, health, step, stop, task};
use route::Route;
use utoipa::openapi::security::{HttpAuthScheme, HttpBuilder, SecurityRequirement, SecurityScheme};
use utoipa::openapi::{ComponentsBuilder, InfoBuilder, LicenseBuilder, OpenApi, OpenApiBuilder};
use utoipa::openapi::{PathsBuilder, RefOr, Schema, tag::TagBuilder};

const ABOUT: &str = "Controller server for two-wheel robots over bad links: poses in, wheel speeds out, and what \
is identified of the floor and the link.\n\nJSON in snake_case; every quantity names its unit (`x_m`, \
`heading_rad`, `left_rad_per_s`). Times that end in `_s` and mark a moment are the robot's own monotonic clock. \
Unknown fields are refused in requests and must be ignored in responses: the contract only grows, and a type that \
goes both ways has a schema for each. Lists are never taken for objects; whole numbers may be written as 20.0. Every \
problem of a request is reported at once: 400 where a schema says no, 409 where all schemas say yes and the state, the \
names that there are, or another field of the same body says no. Only UNAVAILABLE is retried by itself.";

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

/// The contract, all routes and schemas; checked in as `openapi/openapi.json`.
///
/// ```
/// let document = umwelt_api::document();
/// assert!(document.paths.paths.contains_key("/v1/robots/{robot}/step"));
/// ```
pub fn document() -> OpenApi {
    let (mut paths, mut schemas) = (PathsBuilder::new(), route::Schemas::default());
    for route in routes() {
        let (path, item, used) = route.into_parts();
        paths = paths.path(path, item);
        schemas.extend(used);
    }
    limits::apply(&mut schemas);
    schemas.values_mut().for_each(without_examples);
    let tags =
        TAGS.map(|(name, about)| TagBuilder::new().name(name).description(Some(about)).build());
    let license = LicenseBuilder::new().name("MIT OR Apache-2.0").build();
    let info = InfoBuilder::new()
        .title("Umwelt")
        .version("1")
        .description(Some(ABOUT))
        .license(Some(license))
        .build();
    // Without a token where the server has none.
    let bearer = SecurityRequirement::new::<_, [&str; 0], &str>(BEARER, []);
    let scheme = SecurityScheme::Http(HttpBuilder::new().scheme(HttpAuthScheme::Bearer).build());
    let components =
        ComponentsBuilder::new().schemas_from_iter(schemas).security_scheme(BEARER, scheme);
    let mut document = OpenApiBuilder::new()
        .info(info)
        .paths(paths.build())
        .components(Some(components.build()))
        .security(Some([SecurityRequirement::default(), bearer]))
        .tags(Some(tags))
        .build();
    requests::close(&mut document);
    document
}

fn routes() -> impl Iterator<Item = Route> {
    [
        robots(),
        tasks(),
        control(),
        environments(),
        evolve::priors(),
        evolve::training(),
        evolve::evolutions(),
        compare::comparisons(),
        events(),
        server(),
    ]
    .into_iter()
    .flatten()
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

fn robots() -> Vec<Route> {
    vec![
        Route::put("/v1/robots/{robot}", "put_robot", "Describe a robot")
            .tag("robots")
            .about("Creates it or replaces what was said. The task is kept; what was learned is kept unless method, prior or drift changed.")
            .conditional()
            .takes::<robot::Spec>()
            .gives::<robot::Robot>(200, "It was described anew")
            .gives::<robot::Robot>(201, "It was described for the first time")
            .fails(&[400, 409]),
        Route::get("/v1/robots/{robot}", "get_robot", "Show a robot")
            .tag("robots")
            .gives::<robot::Robot>(200, "The robot as it is now")
            .fails(&[400, 404]),
        Route::delete("/v1/robots/{robot}", "delete_robot", "Remove a robot")
            .tag("robots")
            .about("With its task and what was learned. Its agent gets NOT_FOUND and the robot ramps to rest by itself.")
            .conditional()
            .gives_nothing("It is gone")
            .fails(&[400, 404, 409]),
        Route::get("/v1/robots", "list_robots", "List robots")
            .tag("robots")
            .about("In the order of their ids.")
            .paged(MAX_PAGE_SIZE, DEFAULT_PAGE_SIZE, route::ID_TOKEN)
            .query_as::<robot::State>("state", "Only robots in this state")
            .gives::<robot::Page>(200, "Some of the robots")
            .fails(&[400]),
    ]
}

fn tasks() -> Vec<Route> {
    vec![
        Route::put("/v1/robots/{robot}/task", "put_task", "Set the task of a robot")
            .tag("tasks")
            .about("Replaces the one before; begins with the next step. The very task that the robot has already goes on as it is, arrived or not, with the same `etag`: to have it driven again, DELETE it first.")
            .conditional()
            .takes::<task::Spec>()
            .gives::<task::Task>(200, "It replaced another, or is the one that there was")
            .gives::<task::Task>(201, "It was set")
            .fails(&[400, 404, 409]),
        Route::get(
            "/v1/robots/{robot}/task",
            "get_task",
            "Show the task of a robot and its progress",
        )
        .tag("tasks")
        .gives::<task::Task>(200, "The task and how far it has got")
        .fails(&[400, 404]),
        Route::delete("/v1/robots/{robot}/task", "delete_task", "Cancel the task of a robot")
            .tag("tasks")
            .about("The robot ramps to rest.")
            .conditional()
            .gives_nothing("There is no task any more")
            .fails(&[400, 404, 409]),
    ]
}

fn control() -> Vec<Route> {
    vec![
        Route::post("/v1/robots/{robot}/step", "step", "Send observations, get a horizon")
            .tag("control")
            .about("Idempotent on (robot, epoch, sequence): a repeat gets the same answer, a late one the newest horizon. A superseded epoch gets ABORTED.")
            .takes::<step::Request>()
            .gives::<step::Reply>(200, "What to play")
            .fails(&[400, 404, 409, 429, 503]),
        Route::post("/v1/robots/{robot}/stop", "stop_robot", "Stop a robot until it is resumed")
            .tag("control")
            .about("Acts on the next exchange; the task is kept.")
            .gives::<stop::Stop>(200, "It is told to rest")
            .fails(&[400, 404]),
        Route::post("/v1/robots/{robot}/resume", "resume_robot", "Let a stopped robot go on")
            .tag("control")
            .about("Of stops and resumes the last to arrive holds: one that a stop has overtaken has no effect.")
            .gives::<stop::Stop>(200, "It is told to go on")
            .fails(&[400, 404, 409, 503]),
        Route::post("/v1/stop", "stop_all", "Stop all robots until they are resumed")
            .tag("control")
            .gives::<stop::StopAll>(200, "All are told to rest")
            .fails(&[503]),
        Route::post("/v1/resume", "resume_all", "Let all stopped robots go on")
            .tag("control")
            .gives::<stop::StopAll>(200, "All are told to go on")
            .fails(&[503]),
    ]
}

fn environments() -> Vec<Route> {
    vec![
        Route::get("/v1/robots/{robot}/environment", "get_environment", "Show what is identified")
            .tag("environments")
            .gives::<environment::Environment>(200, "The identified environment")
            .fails(&[400, 404]),
        Route::post(
            "/v1/robots/{robot}/environment/reset",
            "reset_environment",
            "Forget what was learned",
        )
        .tag("environments")
        .about("Back to the prior.")
        .gives::<environment::Environment>(200, "The environment as the prior has it")
        .fails(&[400, 404]),
    ]
}

fn events() -> Vec<Route> {
    let resumable = "Resumes behind the event named in `Last-Event-ID`; where some of those since are forgotten, the first event says `missed`.";
    vec![
        Route::get("/v1/robots/{robot}/events", "robot_events", "Follow a robot")
            .tag("events")
            .about(resumable)
            .last_event_id()
            .streams::<event::Event>("One event per `data:` line")
            .fails(&[400, 404, 429]),
        Route::get("/v1/events", "events", "Follow all robots")
            .tag("events")
            .about(resumable)
            .last_event_id()
            .streams::<event::Event>("One event per `data:` line")
            .fails(&[400, 429]),
    ]
}

fn server() -> Vec<Route> {
    vec![
        Route::get("/healthz", "health", "Whether the server lives")
            .tag("server")
            .gives::<health::Health>(200, "It does"),
        Route::get("/readyz", "readiness", "Whether the server takes requests")
            .tag("server")
            .gives::<health::Health>(200, "It does")
            .fails(&[503]),
        Route::get("/openapi.json", "contract", "This document")
            .tag("server")
            .gives_object("OpenAPI 3.1"),
    ]
}
