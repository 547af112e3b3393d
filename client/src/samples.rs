//! What a server answers, for tests.

/// A comparison as a server shows it.
pub const COMPARISON: &str = r#"{
    "comparison": "comparison-12", "state": "queued", "interrupted": 0, "created_unix_s": 1000, "error": null,
    "report": null,
    "spec": {"scenario": "thesis", "methods": ["statistic/20", "bayesian/20", "no-compensation/1"],
             "environments": ["normal", "bad-link"], "trials": 1000, "seed": 1, "time_limit_s": 180, "prior": "thesis"},
    "progress": {"stage": "queued", "trials_done": 0, "trials": 1000, "episodes": 0, "total_episodes": 6040,
                 "elapsed_s": 0, "remaining_s": null}
}"#;

/// An evolution as a server shows it.
pub const EVOLUTION: &str = r#"{
    "evolution": "evolution-12", "state": "queued", "interrupted": 0, "created_unix_s": 1000, "error": null,
    "prior": null, "champion": null,
    "spec": {"environments": ["normal"], "optimizer": "genetic", "population": 24, "generations": 12, "trials": 2,
             "selection_trials": 20, "report_trials": 60, "seed": 1, "crossover_probability": 0.49,
             "reproduction_probability": 0.49, "mutation_probability": 0.02, "expansion": 1.2, "elites": 0,
             "max_deviation_m": 0.1, "max_time_s": 60, "horizon_slots": 1, "prior": "mine"},
    "progress": {"stage": "queued", "generation": 0, "generations": 12, "best_fitness": null, "mean_fitness": null,
                 "episodes": 0, "total_episodes": 1000, "elapsed_s": 0, "remaining_s": null}
}"#;
