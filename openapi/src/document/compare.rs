//! The routes of comparisons.

use super::route::{NUMBER_TOKEN, Route};
use crate::comparison;
use crate::page::{DEFAULT_PAGE_SIZE, MAX_PAGE_SIZE};

const NOTHING_YET: &str = "FAILED_PRECONDITION with NOTHING_YET before it has succeeded.";

pub(super) fn comparisons() -> Vec<Route> {
    vec![
        Route::post("/v1/comparisons", "submit_comparison", "Compare methods in the background")
            .tag("comparisons")
            .about("What is left out is the thesis's. With an `Idempotency-Key` the same body sent again gives the same comparison again, also after a restart of the server; another body under the same key is FAILED_PRECONDITION with IDEMPOTENCY_KEY_REUSED. A key is remembered as long as its comparison is there. RESOURCE_EXHAUSTED where too many wait already.")
            .idempotency_key()
            .takes::<comparison::Request>()
            .gives::<comparison::Comparison>(200, "This key and body gave this comparison before")
            .creates::<comparison::Comparison>("It waits for its turn")
            .fails(&[400, 409, 429, 503]),
        Route::get("/v1/comparisons/{comparison}", "get_comparison", "Show a comparison")
            .tag("comparisons")
            .gives::<comparison::Comparison>(200, "How far it has got, and what came of it")
            .fails(&[400, 404]),
        Route::delete("/v1/comparisons/{comparison}", "delete_comparison", "Remove a comparison")
            .tag("comparisons")
            .about("With its trials. FAILED_PRECONDITION with NOT_ENDED where it has not: cancel it first.")
            .gives_nothing("It is gone")
            .fails(&[400, 404, 409]),
        Route::get("/v1/comparisons", "list_comparisons", "List comparisons")
            .paged(MAX_PAGE_SIZE, DEFAULT_PAGE_SIZE, NUMBER_TOKEN)
            .tag("comparisons")
            .about("The newest first, without their reports.")
            .query_as::<comparison::State>("state", "Only comparisons in this state")
            .gives::<comparison::Page>(200, "Some of the comparisons")
            .fails(&[400]),
        Route::post(
            "/v1/comparisons/{comparison}/cancel",
            "cancel_comparison",
            "Cancel a comparison",
        )
        .tag("comparisons")
        .about("One that is cancelled already is given as it is; FAILED_PRECONDITION with ENDED for one that has succeeded or failed.")
        .gives::<comparison::Comparison>(200, "It is cancelled")
        .fails(&[400, 404, 409]),
        Route::get(
            "/v1/comparisons/{comparison}/events",
            "comparison_events",
            "Follow a comparison",
        )
        .tag("comparisons")
        .about("The state as it is now, whatever `Last-Event-ID`, then each change of it until it has ended. The id of an event is the number of trials that every contender has driven.")
        .last_event_id()
        .streams::<comparison::Event>("One event per `data:` line")
        .fails(&[400, 404, 429]),
        Route::get(
            "/v1/comparisons/{comparison}/figures/{figure}",
            "comparison_figure",
            "Draw a comparison",
        )
        .tag("comparisons")
        .about(&format!("`deviation` and `time` show which share of the trials exceeds how much, one panel for each environment (the thesis's figures 8 to 11); `pareto` shows time against deviation. {NOTHING_YET}"))
        .gives_text(comparison::Figure::MEDIA_TYPE, "The figure")
        .fails(&[400, 404, 409, 429]),
        Route::get(
            "/v1/comparisons/{comparison}/trials.csv",
            "comparison_trials",
            "List every trial of a comparison",
        )
        .tag("comparisons")
        .about(&format!("One row for each trial of each contender in each environment, below a header: `{}`. {NOTHING_YET}", comparison::TRIALS_COLUMNS.join(",")))
        .gives_text(comparison::TRIALS_MEDIA_TYPE, "The trials")
        .fails(&[400, 404, 409, 429]),
        Route::get(
            "/v1/comparisons/{comparison}/report.md",
            "comparison_report",
            "Tell people what came of a comparison",
        )
        .tag("comparisons")
        .about(&format!("Tables, and in plain words what the thesis's claims come to. {NOTHING_YET}"))
        .gives_text(comparison::REPORT_MEDIA_TYPE, "The report")
        .fails(&[400, 404, 409, 429]),
    ]
}
