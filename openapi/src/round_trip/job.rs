//! The names of evolutions and comparisons. What they mean is told in `umwelt-lab`.

use crate::comparison::{self, Scenario};
use crate::evolution;
use serde_json::json;

#[test]
fn names_of_evolutions_are_those_of_the_wire() {
    for state in evolution::State::ALL {
        assert_eq!(serde_json::to_value(state).unwrap(), state.name());
    }
    for figure in evolution::Figure::ALL {
        assert_eq!(serde_json::to_value(figure).unwrap(), figure.name());
        assert_eq!(evolution::Figure::named(figure.name()), Some(figure));
    }
    assert_eq!(evolution::Figure::named("speed"), None);
    use evolution::{Optimizer, Stage};
    for optimizer in [Optimizer::Genetic, Optimizer::CmaEs, Optimizer::EmpiricalBayes] {
        assert_eq!(serde_json::to_value(optimizer).unwrap(), optimizer.name());
    }
    for stage in [
        Stage::Queued,
        Stage::Reference,
        Stage::Generations,
        Stage::Selection,
        Stage::Report,
        Stage::Done,
    ] {
        assert_eq!(serde_json::to_value(stage).unwrap(), stage.name());
    }
}

#[test]
fn names_of_comparisons_are_those_of_the_wire() {
    use comparison::{Figure, Stage};
    for figure in Figure::ALL {
        assert_eq!(serde_json::to_value(figure).unwrap(), figure.name());
        assert_eq!(Figure::named(figure.name()), Some(figure));
    }
    assert_eq!(Figure::named("speed"), None);
    for stage in Stage::ALL {
        assert_eq!(serde_json::to_value(stage).unwrap(), stage.name());
    }
    for scenario in Scenario::ALL {
        assert_eq!(serde_json::to_value(scenario).unwrap(), scenario.name());
        assert_eq!(Scenario::named(scenario.name()), Some(scenario));
    }
}

#[test]
fn a_reader_of_comparisons_ignores_what_it_does_not_know() {
    let spec = json!({"scenario": "of-tomorrow", "methods": ["guess/3"], "environments": ["moon"], "trials": 20_000,
                      "seed": 1, "time_limit_s": 180, "prior": null, "colour": "red"});
    let progress = json!({"stage": "trials", "trials_done": 5, "trials": 9, "episodes": 10, "total_episodes": 18,
                          "elapsed_s": 1, "remaining_s": null, "mood": "good"});
    let body = json!({"comparison": "comparison-1", "state": "running", "spec": spec, "progress": progress,
                      "interrupted": 0, "created_unix_s": 1, "error": null, "report": null, "more": {}});
    let read: comparison::Comparison = serde_json::from_value(body).unwrap();
    assert_eq!((read.spec.trials, read.progress.trials_done), (20_000, 5));
}
