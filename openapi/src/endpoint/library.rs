//! Things with names: priors and simulated environments.

use super::{Answer, Endpoint, Operation, Paged, delete, get, put};
use crate::page::{DEFAULT_PAGE_SIZE, ID_TOKEN, MAX_PAGE_SIZE};
use crate::{prior, training};

endpoints! {
    /// Name a prior
    PUT_PRIOR: Endpoint<prior::Spec, prior::Prior> = put("put_prior", "/v1/priors/{prior}")
        .tag("priors")
        .about("Creates it or replaces what was put. FAILED_PRECONDITION with BUILT_IN for one that comes with the server, with PRIOR_IN_USE where robots use it and the values would change.")
        .conditional()
        .takes::<prior::Spec>()
        .gives(&[(200, "It was put anew"), (201, "It was put for the first time")])
        .fails(&[400, 409]);
    /// Show a prior
    GET_PRIOR: Endpoint<(), prior::Prior> = get("get_prior", "/v1/priors/{prior}")
        .tag("priors")
        .gives(&[(200, "The prior, where it comes from and which robots use it")])
        .fails(&[400, 404]);
    /// Remove a prior
    DELETE_PRIOR: Endpoint = delete("delete_prior", "/v1/priors/{prior}")
        .tag("priors")
        .about("FAILED_PRECONDITION with BUILT_IN for one that comes with the server, with PRIOR_IN_USE where robots use it.")
        .conditional()
        .answers(Answer::Nothing("It is gone"))
        .fails(&[400, 404, 409]);
    /// List priors
    LIST_PRIORS: Endpoint<(), prior::Page> = get("list_priors", "/v1/priors")
        .tag("priors")
        .about("In the order of their names, built-in ones among them.")
        .paged(Paged { max: MAX_PAGE_SIZE, default: DEFAULT_PAGE_SIZE, token: ID_TOKEN })
        .gives(&[(200, "Some of the priors")])
        .fails(&[400]);

    /// Name a simulated environment
    PUT_TRAINING_ENVIRONMENT: Endpoint<training::Spec, training::Environment> =
        put("put_training_environment", "/v1/environments/{environment}")
        .tag("training")
        .about("Creates it or replaces what was put; an evolution that was submitted keeps what it was submitted with. FAILED_PRECONDITION with BUILT_IN for one that comes with the server.")
        .conditional()
        .takes::<training::Spec>()
        .gives(&[(200, "It was put anew"), (201, "It was put for the first time")])
        .fails(&[400, 409]);
    /// Show a simulated environment
    GET_TRAINING_ENVIRONMENT: Endpoint<(), training::Environment> =
        get("get_training_environment", "/v1/environments/{environment}")
        .tag("training")
        .gives(&[(200, "The environment")])
        .fails(&[400, 404]);
    /// Remove a simulated environment
    DELETE_TRAINING_ENVIRONMENT: Endpoint =
        delete("delete_training_environment", "/v1/environments/{environment}")
        .tag("training")
        .about("FAILED_PRECONDITION with BUILT_IN for one that comes with the server.")
        .conditional()
        .answers(Answer::Nothing("It is gone"))
        .fails(&[400, 404, 409]);
    /// List simulated environments
    LIST_TRAINING_ENVIRONMENTS: Endpoint<(), training::Page> =
        get("list_training_environments", "/v1/environments")
        .tag("training")
        .about("In the order of their names, built-in ones among them.")
        .paged(Paged { max: training::MAX_PAGE_SIZE, default: DEFAULT_PAGE_SIZE, token: ID_TOKEN })
        .gives(&[(200, "Some of the environments")])
        .fails(&[400]);
}
