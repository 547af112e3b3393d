//! The routes of priors, simulated environments and evolutions.

use super::route::{ID_TOKEN, NUMBER_TOKEN, Route};
use crate::page::{DEFAULT_PAGE_SIZE, MAX_PAGE_SIZE};
use crate::{evolution, prior, training};

pub(super) fn priors() -> Vec<Route> {
    vec![
        Route::put("/v1/priors/{prior}", "put_prior", "Name a prior")
            .tag("priors")
            .about("Creates it or replaces what was put. FAILED_PRECONDITION with BUILT_IN for one that comes with the server, with PRIOR_IN_USE where robots use it and the values would change.")
            .conditional()
            .takes::<prior::Spec>()
            .gives::<prior::Prior>(200, "It was put anew")
            .gives::<prior::Prior>(201, "It was put for the first time")
            .fails(&[400, 409]),
        Route::get("/v1/priors/{prior}", "get_prior", "Show a prior")
            .tag("priors")
            .gives::<prior::Prior>(200, "The prior, where it comes from and which robots use it")
            .fails(&[400, 404]),
        Route::delete("/v1/priors/{prior}", "delete_prior", "Remove a prior")
            .tag("priors")
            .about("FAILED_PRECONDITION with BUILT_IN for one that comes with the server, with PRIOR_IN_USE where robots use it.")
            .conditional()
            .gives_nothing("It is gone")
            .fails(&[400, 404, 409]),
        Route::get("/v1/priors", "list_priors", "List priors")
            .paged(MAX_PAGE_SIZE, DEFAULT_PAGE_SIZE, ID_TOKEN)
            .tag("priors")
            .about("In the order of their names, built-in ones among them.")
            .gives::<prior::Page>(200, "Some of the priors")
            .fails(&[400]),
    ]
}

pub(super) fn training() -> Vec<Route> {
    let max = training::MAX_PAGE_SIZE;
    vec![
        Route::put(
            "/v1/environments/{environment}",
            "put_training_environment",
            "Name a simulated environment",
        )
        .tag("training")
        .about("Creates it or replaces what was put; an evolution that was submitted keeps what it was submitted with. FAILED_PRECONDITION with BUILT_IN for one that comes with the server.")
        .conditional()
        .takes::<training::Spec>()
        .gives::<training::Environment>(200, "It was put anew")
        .gives::<training::Environment>(201, "It was put for the first time")
        .fails(&[400, 409]),
        Route::get(
            "/v1/environments/{environment}",
            "get_training_environment",
            "Show a simulated environment",
        )
        .tag("training")
        .gives::<training::Environment>(200, "The environment")
        .fails(&[400, 404]),
        Route::delete(
            "/v1/environments/{environment}",
            "delete_training_environment",
            "Remove a simulated environment",
        )
        .tag("training")
        .about("FAILED_PRECONDITION with BUILT_IN for one that comes with the server.")
        .conditional()
        .gives_nothing("It is gone")
        .fails(&[400, 404, 409]),
        Route::get(
            "/v1/environments",
            "list_training_environments",
            "List simulated environments",
        )
        .paged(max, DEFAULT_PAGE_SIZE, ID_TOKEN)
        .tag("training")
        .about("In the order of their names, built-in ones among them.")
        .gives::<training::Page>(200, "Some of the environments")
        .fails(&[400]),
    ]
}

pub(super) fn evolutions() -> Vec<Route> {
    let (max, default) = (evolution::MAX_GENERATIONS_SIZE, evolution::DEFAULT_GENERATIONS_SIZE);
    vec![
        Route::post("/v1/evolutions", "submit_evolution", "Search for a prior in the background")
            .tag("evolutions")
            .about("What is left out comes from the preset. With an `Idempotency-Key` the same body sent again gives the same evolution again, also after a restart of the server; another body under the same key is FAILED_PRECONDITION with IDEMPOTENCY_KEY_REUSED. A key is remembered as long as its evolution is there. ALREADY_EXISTS with NAME_TAKEN where the name for the champion is taken. RESOURCE_EXHAUSTED where too many wait already.")
            .idempotency_key()
            .takes::<evolution::Request>()
            .gives::<evolution::Evolution>(200, "This key and body gave this evolution before")
            .creates::<evolution::Evolution>("It waits for its turn")
            .fails(&[400, 409, 429, 503]),
        Route::get("/v1/evolutions/{evolution}", "get_evolution", "Show an evolution")
            .tag("evolutions")
            .gives::<evolution::Evolution>(200, "How far it has got, and what it found")
            .fails(&[400, 404]),
        Route::delete("/v1/evolutions/{evolution}", "delete_evolution", "Remove an evolution")
            .tag("evolutions")
            .about("With its generations; a prior that it found stays. FAILED_PRECONDITION with NOT_ENDED where it has not: cancel it first.")
            .gives_nothing("It is gone")
            .fails(&[400, 404, 409]),
        Route::get("/v1/evolutions", "list_evolutions", "List evolutions")
            .paged(MAX_PAGE_SIZE, DEFAULT_PAGE_SIZE, NUMBER_TOKEN)
            .tag("evolutions")
            .about("The newest first.")
            .query_as::<evolution::State>("state", "Only evolutions in this state")
            .gives::<evolution::Page>(200, "Some of the evolutions")
            .fails(&[400]),
        Route::post(
            "/v1/evolutions/{evolution}/cancel",
            "cancel_evolution",
            "Cancel an evolution",
        )
        .tag("evolutions")
        .about("What came of its generations stays. One that is cancelled already is given as it is; FAILED_PRECONDITION with ENDED for one that has succeeded or failed.")
        .gives::<evolution::Evolution>(200, "It is cancelled")
        .fails(&[400, 404, 409]),
        Route::get(
            "/v1/evolutions/{evolution}/generations",
            "list_generations",
            "List the generations of an evolution",
        )
        .paged(max, default, NUMBER_TOKEN)
        .tag("evolutions")
        .about("In their order, as far as they have ended.")
        .gives::<evolution::GenerationsPage>(200, "Some of the generations")
        .fails(&[400, 404]),
        Route::get(
            "/v1/evolutions/{evolution}/events",
            "evolution_events",
            "Follow an evolution",
        )
        .tag("evolutions")
        .about("The generations behind `Last-Event-ID` (all without it), the state as it is now, then each generation and each change of state until it has ended. The id of an event is the number of generations that have ended: none is missed, also after a restart of the server.")
        .last_event_id()
        .streams::<evolution::Event>("One event per `data:` line")
        .fails(&[400, 404, 429]),
        Route::get(
            "/v1/evolutions/{evolution}/figures/{figure}",
            "evolution_figure",
            "Draw the generations of an evolution",
        )
        .tag("evolutions")
        .about("Best and mean of each generation in each environment: `deviation` is the thesis's figure 6, `time` its figure 7. FAILED_PRECONDITION with NOTHING_YET before the first generation has ended.")
        .gives_text(evolution::Figure::MEDIA_TYPE, "The figure")
        .fails(&[400, 404, 409, 429]),
    ]
}
