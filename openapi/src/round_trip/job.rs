//! The names of evolutions and comparisons. What they mean stands in `umwelt-lab`.

use crate::comparison::{self, Scenario};
use crate::evolution;
use serde::Serialize;
use serde::de::DeserializeOwned;
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

const EVOLUTION: &str = r#"{"evolution":"evolution-12","state":"succeeded","spec":{"environments":["normal"],"optimizer":"genetic","population":24,"generations":12,"trials":2,"selection_trials":20,"report_trials":60,"seed":1,"crossover_probability":0.49,"reproduction_probability":0.49,"mutation_probability":0.02,"expansion":1.2,"elites":0,"max_deviation_m":0.1,"max_time_s":60.0,"horizon_slots":1,"prior":"mine"},"progress":{"stage":"done","generation":12,"generations":12,"best_fitness":1.25,"mean_fitness":null,"episodes":1000,"total_episodes":1000,"elapsed_s":1.5,"remaining_s":null},"interrupted":2,"created_unix_s":1000,"error":"why","prior":"mine","champion":null}"#;

const COMPARISON: &str = r#"{"comparison":"comparison-12","state":"succeeded","spec":{"scenario":"thesis","methods":["statistic/20"],"environments":["normal"],"trials":9,"seed":1,"time_limit_s":180.0,"prior":null},"progress":{"stage":"done","trials_done":9,"trials":9,"episodes":9,"total_episodes":9,"elapsed_s":0.1,"remaining_s":2.5},"interrupted":0,"created_unix_s":1000,"error":null,"report":{"trials":9,"environments":[],"claims":[]}}"#;

/// What is read of `text` is written as `text`, byte for byte.
fn stays<T: Serialize + DeserializeOwned>(text: &str) {
    let read: T = serde_json::from_str(text).unwrap();
    assert_eq!(serde_json::to_string(&read).unwrap(), text);
}

/// The order of the fields is part of the contract, so that answers of two versions can be compared as text.
#[test]
fn jobs_pages_and_events_are_written_byte_for_byte_as_ever() {
    stays::<evolution::Evolution>(EVOLUTION);
    stays::<comparison::Comparison>(COMPARISON);
    let unreadable = r#"{"name":"n","written_by":null,"why":"w","remedy":"r"}"#;
    for rest in [
        r#""next_page_token":null"#.to_owned(),
        format!(r#""unreadable":[{unreadable}],"next_page_token":"7""#),
    ] {
        stays::<evolution::Page>(&format!(r#"{{"evolutions":[{EVOLUTION}],{rest}}}"#));
        stays::<comparison::Page>(&format!(r#"{{"comparisons":[{COMPARISON}],{rest}}}"#));
    }
    let event = |noun: &str, progress: &str| {
        format!(
            r#"{{"id":12,"{noun}":"{noun}-12","type":"state","state":"failed","progress":{progress},"error":"e"}}"#
        )
    };
    let progress = r#"{"stage":"done","generation":12,"generations":12,"best_fitness":1.25,"mean_fitness":null,"episodes":1000,"total_episodes":1000,"elapsed_s":1.5,"remaining_s":null}"#;
    stays::<evolution::Event>(&event("evolution", progress));
    let progress = r#"{"stage":"done","trials_done":9,"trials":9,"episodes":9,"total_episodes":9,"elapsed_s":0.1,"remaining_s":2.5}"#;
    stays::<comparison::Event>(&event("comparison", progress));
    let channel = r#"{"mu":0.0,"k":1.0,"r":4.0,"s":0.045}"#;
    let prior = format!(
        r#"{{"forward":{channel},"lateral":{channel},"turn":{channel},"drift":{channel}}}"#
    );
    stays::<evolution::Event>(&format!(
        r#"{{"id":1,"evolution":"evolution-12","type":"generation","generation":{{"index":0,"best_fitness":0.5,"mean_fitness":0.25,"prior":{prior},"environments":[]}}}}"#
    ));
}

#[test]
fn a_job_without_its_id_or_a_page_without_its_list_is_none() {
    let nameless = EVOLUTION.replacen("evolution", "comparison", 1);
    let why = serde_json::from_str::<evolution::Evolution>(&nameless).unwrap_err().to_string();
    assert!(why.starts_with("missing field `evolution`"), "{why}");
    let why = serde_json::from_str::<evolution::Page>(r#"{"comparisons":[]}"#).unwrap_err();
    assert!(why.to_string().starts_with("missing field `evolutions`"), "{why}");
}
