//! Every route, in reading order.

use crate::http::app::App;
use crate::http::deadline;
use crate::http::guard;
use crate::http::routes::{
    control, environment, environments, events, jobs, priors, robots, server, tasks,
};
use crate::resource::failure::{self, Failure};
use axum::Router;
use axum::extract::Request;
use axum::http::StatusCode;
use axum::middleware;
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post, put};
use std::any::Any;
use std::sync::Arc;
use tower_http::catch_panic::CatchPanicLayer;
use tower_http::trace::TraceLayer;
use umwelt_api::problem::{Detail, Status, reason};
use umwelt_api::{comparison, evolution};
use umwelt_lab::comparison::Comparison;
use umwelt_lab::evolution::Evolution;

/// The routes of `app`, and before them who may ask.
pub(crate) fn router(app: App, rules: guard::Rules) -> Router {
    // Around all the routes, since only there answers have their `Allow`.
    Router::new()
        .fallback_service(routes(app))
        .layer(middleware::from_fn_with_state(Arc::new(rules), guard::check))
        .layer(TraceLayer::new_for_http())
}

fn routes(app: App) -> Router {
    Router::new()
        // Robots
        .route("/v1/robots", get(robots::list))
        .route("/v1/robots/{robot}", put(robots::put).get(robots::get).delete(robots::delete))
        // Tasks
        .route("/v1/robots/{robot}/task", put(tasks::put).get(tasks::get).delete(tasks::delete))
        // Control: the hot path, and the stop
        .route("/v1/robots/{robot}/step", post(control::step))
        .route("/v1/robots/{robot}/stop", post(control::stop))
        .route("/v1/robots/{robot}/resume", post(control::resume))
        .route("/v1/stop", post(control::stop_all))
        .route("/v1/resume", post(control::resume_all))
        // What is identified
        .route("/v1/robots/{robot}/environment", get(environment::get))
        .route("/v1/robots/{robot}/environment/reset", post(environment::reset))
        // Priors by name
        .route("/v1/priors", get(priors::list))
        .route("/v1/priors/{prior}", put(priors::put).get(priors::get).delete(priors::delete))
        // Simulated environments by name
        .route("/v1/environments", get(environments::list))
        .route(
            "/v1/environments/{environment}",
            put(environments::put).get(environments::get).delete(environments::delete),
        )
        // Evolutions: priors searched for in the background
        .route(
            "/v1/evolutions",
            post(jobs::submit::<Evolution, { evolution::MAX_BODY }>).get(jobs::list::<Evolution>),
        )
        .route(
            "/v1/evolutions/{evolution}",
            get(jobs::get::<Evolution>).delete(jobs::delete::<Evolution>),
        )
        .route("/v1/evolutions/{evolution}/cancel", post(jobs::cancel::<Evolution>))
        .route("/v1/evolutions/{evolution}/generations", get(jobs::evolution::generations))
        .route("/v1/evolutions/{evolution}/events", get(jobs::events::<Evolution>))
        .route("/v1/evolutions/{evolution}/figures/{figure}", get(jobs::evolution::figure))
        // Comparisons: methods on the same seeds, in the background
        .route(
            "/v1/comparisons",
            post(jobs::submit::<Comparison, { comparison::MAX_BODY }>)
                .get(jobs::list::<Comparison>),
        )
        .route(
            "/v1/comparisons/{comparison}",
            get(jobs::get::<Comparison>).delete(jobs::delete::<Comparison>),
        )
        .route("/v1/comparisons/{comparison}/cancel", post(jobs::cancel::<Comparison>))
        .route("/v1/comparisons/{comparison}/events", get(jobs::events::<Comparison>))
        .route("/v1/comparisons/{comparison}/figures/{figure}", get(jobs::comparison::figure))
        .route("/v1/comparisons/{comparison}/trials.csv", get(jobs::comparison::trials))
        .route("/v1/comparisons/{comparison}/report.md", get(jobs::comparison::report))
        // What happens
        .route("/v1/robots/{robot}/events", get(events::of_robot))
        .route("/v1/events", get(events::of_all))
        // The server itself
        .route("/healthz", get(server::health))
        .route("/readyz", get(server::readiness))
        .route("/openapi.json", get(server::contract))
        // Everything else
        .fallback(no_such_path)
        .method_not_allowed_fallback(no_such_method)
        .layer(middleware::from_fn_with_state(app.deadlines, deadline::keep))
        .layer(CatchPanicLayer::custom(panicked))
        .with_state(app)
}

async fn no_such_path(request: Request) -> Failure {
    let path = request.uri().path();
    let detail =
        Detail::new(reason::NO_SUCH_RESOURCE, "", path, "GET /openapi.json lists the paths");
    Failure::new(Status::NotFound, "there is nothing at this path").with(detail)
}

async fn no_such_method(request: Request) -> Failure {
    let method = request.method().as_str();
    let detail = Detail::new(reason::METHOD_NOT_ALLOWED, "", method, "use one that Allow names");
    Failure::new(Status::Unimplemented, format!("there is no {method} at this path"))
        .with(detail)
        .under(StatusCode::METHOD_NOT_ALLOWED.as_u16())
}

fn panicked(panic: Box<dyn Any + Send>) -> Response {
    let said = panic.downcast_ref::<String>().map(String::as_str);
    let said = said.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("nothing");
    tracing::error!(panic = said, "a route panicked");
    failure::internal("the server made a mistake; its log says which").into_response()
}
