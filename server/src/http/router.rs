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
use axum::handler::Handler;
use axum::http::StatusCode;
use axum::middleware;
use axum::response::{IntoResponse, Response};
use axum::routing::{delete, get, patch, post, put};
use std::any::Any;
use std::sync::Arc;
use tower_http::catch_panic::CatchPanicLayer;
use tower_http::trace::TraceLayer;
use umwelt_api::endpoint::{self, Endpoint, Method, Operation};
use umwelt_api::problem::{Detail, Status, reason};
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
    let Routes { router, .. } = every_route();
    router
        .fallback(no_such_path)
        .method_not_allowed_fallback(no_such_method)
        .layer(middleware::from_fn_with_state(app.deadlines, deadline::keep))
        .layer(CatchPanicLayer::custom(panicked))
        .with_state(app)
}

fn every_route() -> Routes {
    Routes::default()
        // Robots, their tasks, the hot path and the stop
        .at(endpoint::LIST_ROBOTS, robots::list)
        .at(endpoint::PUT_ROBOT, robots::put)
        .at(endpoint::PATCH_ROBOT, robots::patch)
        .at(endpoint::GET_ROBOT, robots::get)
        .at(endpoint::DELETE_ROBOT, robots::delete)
        .at(endpoint::PUT_TASK, tasks::put)
        .at(endpoint::GET_TASK, tasks::get)
        .at(endpoint::DELETE_TASK, tasks::delete)
        .at(endpoint::STEP, control::step)
        .at(endpoint::STOP_ROBOT, control::stop)
        .at(endpoint::RESUME_ROBOT, control::resume)
        .at(endpoint::STOP_ALL, control::stop_all)
        .at(endpoint::RESUME_ALL, control::resume_all)
        // What is identified, and what happens
        .at(endpoint::GET_ENVIRONMENT, environment::get)
        .at(endpoint::RESET_ENVIRONMENT, environment::reset)
        .at(endpoint::ROBOT_EVENTS, events::of_robot)
        .at(endpoint::EVENTS, events::of_all)
        // Priors and simulated environments by name
        .at(endpoint::LIST_PRIORS, priors::list)
        .at(endpoint::PUT_PRIOR, priors::put)
        .at(endpoint::GET_PRIOR, priors::get)
        .at(endpoint::DELETE_PRIOR, priors::delete)
        .at(endpoint::LIST_TRAINING_ENVIRONMENTS, environments::list)
        .at(endpoint::PUT_TRAINING_ENVIRONMENT, environments::put)
        .at(endpoint::GET_TRAINING_ENVIRONMENT, environments::get)
        .at(endpoint::DELETE_TRAINING_ENVIRONMENT, environments::delete)
        // Evolutions: priors searched for in the background
        .at(endpoint::SUBMIT_EVOLUTION, jobs::submit::<Evolution>)
        .at(endpoint::LIST_EVOLUTIONS, jobs::list::<Evolution>)
        .at(endpoint::GET_EVOLUTION, jobs::get::<Evolution>)
        .at(endpoint::DELETE_EVOLUTION, jobs::delete::<Evolution>)
        .at(endpoint::CANCEL_EVOLUTION, jobs::cancel::<Evolution>)
        .at(endpoint::LIST_GENERATIONS, jobs::evolution::generations)
        .at(endpoint::EVOLUTION_EVENTS, jobs::events::<Evolution>)
        .at(endpoint::EVOLUTION_FIGURE, jobs::evolution::figure)
        // Comparisons: methods on the same seeds, in the background
        .at(endpoint::SUBMIT_COMPARISON, jobs::submit::<Comparison>)
        .at(endpoint::LIST_COMPARISONS, jobs::list::<Comparison>)
        .at(endpoint::GET_COMPARISON, jobs::get::<Comparison>)
        .at(endpoint::DELETE_COMPARISON, jobs::delete::<Comparison>)
        .at(endpoint::CANCEL_COMPARISON, jobs::cancel::<Comparison>)
        .at(endpoint::COMPARISON_EVENTS, jobs::events::<Comparison>)
        .at(endpoint::COMPARISON_FIGURE, jobs::comparison::figure)
        .at(endpoint::COMPARISON_TRIALS, jobs::comparison::trials)
        .at(endpoint::COMPARISON_REPORT, jobs::comparison::report)
        // The server itself
        .at(endpoint::HEALTH, server::health)
        .at(endpoint::READINESS, server::readiness)
        .at(endpoint::CONTRACT, server::contract)
}

/// The routes so far. Only what the contract has can be one.
#[derive(Default)]
struct Routes {
    router: Router<App>,
    served: Vec<Operation>,
}

impl Routes {
    /// Serves an endpoint by `handler`.
    fn at<B, A, T: 'static>(
        mut self,
        endpoint: Endpoint<B, A>,
        handler: impl Handler<T, App>,
    ) -> Self {
        let operation = endpoint.operation();
        let method = match operation.method {
            Method::Get => get(handler),
            Method::Put => put(handler),
            Method::Patch => patch(handler),
            Method::Post => post(handler),
            Method::Delete => delete(handler),
        };
        self.router = self.router.route(operation.path, method);
        self.served.push(operation);
        self
    }
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
    tracing::error!(panic = said, "route panicked");
    failure::internal("the server made a mistake; its log says which").into_response()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// Guards against an endpoint that the contract has and the server has not.
    #[test]
    fn every_endpoint_of_the_contract_is_served() {
        let served: BTreeSet<_> = every_route().served.iter().map(ToString::to_string).collect();
        let contract: BTreeSet<_> = endpoint::all().map(ToString::to_string).collect();
        assert_eq!(served, contract);
    }
}
