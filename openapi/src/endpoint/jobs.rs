//! What is done in the background: evolutions and comparisons.

use super::{Answer, Endpoint, Operation, Paged, delete, get, post};
use crate::page::{DEFAULT_PAGE_SIZE, MAX_PAGE_SIZE, NUMBER_TOKEN};
use crate::{comparison, evolution};

const PAGES: Paged = Paged { max: MAX_PAGE_SIZE, default: DEFAULT_PAGE_SIZE, token: NUMBER_TOKEN };

endpoints! {
    /// Search for a prior in the background
    SUBMIT_EVOLUTION: Endpoint<evolution::Request, evolution::Evolution> =
        post("submit_evolution", "/v1/evolutions")
        .tag("evolutions")
        .about("What is left out comes from the preset. With an `Idempotency-Key` the same body sent again gives the same evolution again, also after a restart of the server; another body under the same key is FAILED_PRECONDITION with IDEMPOTENCY_KEY_REUSED. A key is remembered as long as its evolution is there. ALREADY_EXISTS with NAME_TAKEN where the name for the champion is taken. RESOURCE_EXHAUSTED where too many wait already.")
        .keyed()
        .takes::<evolution::Request>()
        .creates(&[(200, "This key and body gave this evolution before"), (201, "It waits for its turn")])
        .fails(&[400, 409, 429, 503]);
    /// Show an evolution
    GET_EVOLUTION: Endpoint<(), evolution::Evolution> =
        get("get_evolution", "/v1/evolutions/{evolution}")
        .tag("evolutions")
        .gives(&[(200, "How far it has got, and what it found")])
        .fails(&[400, 404]);
    /// Remove an evolution
    DELETE_EVOLUTION: Endpoint = delete("delete_evolution", "/v1/evolutions/{evolution}")
        .tag("evolutions")
        .about("With its generations; a prior that it found stays. FAILED_PRECONDITION with NOT_ENDED where it has not: cancel it first.")
        .answers(Answer::Nothing("It is gone"))
        .fails(&[400, 404, 409]);
    /// List evolutions
    LIST_EVOLUTIONS: Endpoint<(), evolution::Page> = get("list_evolutions", "/v1/evolutions")
        .tag("evolutions")
        .about("The newest first.")
        .paged(PAGES)
        .by_state::<evolution::State>("Only evolutions in this state")
        .gives(&[(200, "Some of the evolutions")])
        .fails(&[400]);
    /// Cancel an evolution
    CANCEL_EVOLUTION: Endpoint<(), evolution::Evolution> =
        post("cancel_evolution", "/v1/evolutions/{evolution}/cancel")
        .tag("evolutions")
        .about("What came of its generations stays. One that is cancelled already is given as it is; FAILED_PRECONDITION with ENDED for one that has succeeded or failed.")
        .gives(&[(200, "It is cancelled")])
        .fails(&[400, 404, 409]);
    /// List the generations of an evolution
    LIST_GENERATIONS: Endpoint<(), evolution::GenerationsPage> =
        get("list_generations", "/v1/evolutions/{evolution}/generations")
        .tag("evolutions")
        .about("In their order, as far as they have ended.")
        .paged(Paged {
            max: evolution::MAX_GENERATIONS_SIZE,
            default: evolution::DEFAULT_GENERATIONS_SIZE,
            token: NUMBER_TOKEN,
        })
        .gives(&[(200, "Some of the generations")])
        .fails(&[400, 404]);
    /// Follow an evolution
    EVOLUTION_EVENTS: Endpoint<(), evolution::Event> =
        get("evolution_events", "/v1/evolutions/{evolution}/events")
        .tag("evolutions")
        .about("The generations behind `Last-Event-ID` (all without it), the state as it is now, then each generation and each change of state until it has ended. The id of an event is the number of generations that have ended: none is missed, also after a restart of the server.")
        .streams()
        .fails(&[400, 404, 429]);
    /// Draw the generations of an evolution
    EVOLUTION_FIGURE: Endpoint =
        get("evolution_figure", "/v1/evolutions/{evolution}/figures/{figure}")
        .tag("evolutions")
        .about("Best and mean of each generation in each environment: `deviation` is the thesis's figure 6, `time` its figure 7. FAILED_PRECONDITION with NOTHING_YET before the first generation has ended.")
        .answers(Answer::Document(evolution::Figure::MEDIA_TYPE, "The figure"))
        .fails(&[400, 404, 409, 429]);

    /// Compare methods in the background
    SUBMIT_COMPARISON: Endpoint<comparison::Request, comparison::Comparison> =
        post("submit_comparison", "/v1/comparisons")
        .tag("comparisons")
        .about("What is left out is the thesis's. With an `Idempotency-Key` the same body sent again gives the same comparison again, also after a restart of the server; another body under the same key is FAILED_PRECONDITION with IDEMPOTENCY_KEY_REUSED. A key is remembered as long as its comparison is there. RESOURCE_EXHAUSTED where too many wait already.")
        .keyed()
        .takes::<comparison::Request>()
        .creates(&[(200, "This key and body gave this comparison before"), (201, "It waits for its turn")])
        .fails(&[400, 409, 429, 503]);
    /// Show a comparison
    GET_COMPARISON: Endpoint<(), comparison::Comparison> =
        get("get_comparison", "/v1/comparisons/{comparison}")
        .tag("comparisons")
        .gives(&[(200, "How far it has got, and what came of it")])
        .fails(&[400, 404]);
    /// Remove a comparison
    DELETE_COMPARISON: Endpoint = delete("delete_comparison", "/v1/comparisons/{comparison}")
        .tag("comparisons")
        .about("With its trials. FAILED_PRECONDITION with NOT_ENDED where it has not: cancel it first.")
        .answers(Answer::Nothing("It is gone"))
        .fails(&[400, 404, 409]);
    /// List comparisons
    LIST_COMPARISONS: Endpoint<(), comparison::Page> = get("list_comparisons", "/v1/comparisons")
        .tag("comparisons")
        .about("The newest first, without their reports.")
        .paged(PAGES)
        .by_state::<comparison::State>("Only comparisons in this state")
        .gives(&[(200, "Some of the comparisons")])
        .fails(&[400]);
    /// Cancel a comparison
    CANCEL_COMPARISON: Endpoint<(), comparison::Comparison> =
        post("cancel_comparison", "/v1/comparisons/{comparison}/cancel")
        .tag("comparisons")
        .about("One that is cancelled already is given as it is; FAILED_PRECONDITION with ENDED for one that has succeeded or failed.")
        .gives(&[(200, "It is cancelled")])
        .fails(&[400, 404, 409]);
    /// Follow a comparison
    COMPARISON_EVENTS: Endpoint<(), comparison::Event> =
        get("comparison_events", "/v1/comparisons/{comparison}/events")
        .tag("comparisons")
        .about("The state as it is now, whatever `Last-Event-ID`, then each change of it until it has ended. The id of an event is the number of trials that every contender has driven.")
        .streams()
        .fails(&[400, 404, 429]);
    /// Draw a comparison
    COMPARISON_FIGURE: Endpoint =
        get("comparison_figure", "/v1/comparisons/{comparison}/figures/{figure}")
        .tag("comparisons")
        .about("`deviation` and `time` show which share of the trials exceeds how much, one panel for each environment (the thesis's figures 8 to 11); `pareto` shows time against deviation. FAILED_PRECONDITION with NOTHING_YET before it has succeeded.")
        .answers(Answer::Document(comparison::Figure::MEDIA_TYPE, "The figure"))
        .fails(&[400, 404, 409, 429]);
    /// List every trial of a comparison
    COMPARISON_TRIALS: Endpoint =
        get("comparison_trials", "/v1/comparisons/{comparison}/trials.csv")
        .tag("comparisons")
        .about("One row for each trial of each contender in each environment, below a header: `environment,contender,trial,arrived,time_s,deviation_m,recognised_samples,covered_samples,samples`. FAILED_PRECONDITION with NOTHING_YET before it has succeeded.")
        .answers(Answer::Document(comparison::TRIALS_MEDIA_TYPE, "The trials"))
        .fails(&[400, 404, 409, 429]);
    /// Tell people what came of a comparison
    COMPARISON_REPORT: Endpoint =
        get("comparison_report", "/v1/comparisons/{comparison}/report.md")
        .tag("comparisons")
        .about("Tables, and in plain words what the thesis's claims come to. FAILED_PRECONDITION with NOTHING_YET before it has succeeded.")
        .answers(Answer::Document(comparison::REPORT_MEDIA_TYPE, "The report"))
        .fails(&[400, 404, 409, 429]);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Guards against a kind of job whose client asks elsewhere than the table says.
    #[test]
    fn a_kind_of_job_is_where_its_kind_says() {
        use crate::job::JobKind;
        let at = |list: &str, name: &str| (format!("/v1/{list}"), format!("/v1/{list}/{{{name}}}"));
        let of = |all: Operation, one: Operation| (all.path.to_owned(), one.path.to_owned());
        let evolutions = of(LIST_EVOLUTIONS.operation(), GET_EVOLUTION.operation());
        let comparisons = of(LIST_COMPARISONS.operation(), GET_COMPARISON.operation());
        assert_eq!(evolutions, at(evolution::EvolutionKind::LIST, evolution::EvolutionKind::NAME));
        assert_eq!(
            comparisons,
            at(comparison::ComparisonKind::LIST, comparison::ComparisonKind::NAME)
        );
    }

    #[test]
    fn the_columns_of_the_trials_are_those_that_are_written() {
        let columns = comparison::TRIALS_COLUMNS.join(",");
        assert!(COMPARISON_TRIALS.operation().about.contains(&format!("`{columns}`")));
    }
}
