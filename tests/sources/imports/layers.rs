//! The layers of a crate, and the imports that point upward in them.

use crate::graph::{Graph, line};

/// The layers of a package from the lowest up. A layer is a list of files, and of folders with a `/` at the end, below
/// `src`; they may import each other and what is in lower layers. A file belongs to the longest entry that it begins with.
pub type Layers<'a> = &'a [&'a [&'a str]];

/// The layers of every package.
pub const LAYERS: &[(&str, Layers)] = &[
    ("umwelt-core", CORE),
    ("umwelt-api", API),
    ("umwelt-no-schema", &[&["lib.rs"]]),
    ("umwelt-lab", LAB),
    ("umwelt-server", SERVER),
    ("umwelt-memory", &[&["lib.rs"]]),
    ("umwelt-client", CLIENT),
    ("umwelt-agent", AGENT),
    ("umwelt-tests", TESTS),
];

/// What only files in these folders of a package name: crates that stand for a subject.
pub const SUBJECTS: &[(&str, &[&str], &[&str])] = &[
    ("umwelt-server", &["axum", "hyper_util", "tower_http"], &["http/", "program/", "lib.rs"]),
    ("umwelt-api", &["umwelt_core"], &["conversion/", "built_in.rs", "training/simulator.rs"]),
];

const CORE: Layers = &[
    &["robot/geometry/"],
    &["robot/time.rs"],
    &["robot/kinematics/"],
    &["robot/horizon.rs"],
    &["robot/"],
    &["control/conjugate/"],
    &["control/derived.rs", "control/settings.rs", "control/task.rs", "control/condition.rs"],
    &["control/commands/"],
    &["control/prediction/"],
    &["control/identification/"],
    &["control/drive/", "control/fusion/"],
    &["control/steering.rs"],
    &["control/watch/", "control/check/", "control/square/"],
    &["control/controller/"],
    &["control/mod.rs"],
    &["simulation/draws.rs"],
    &["simulation/link/", "simulation/plant/"],
    &["simulation/episode/"],
    &["simulation/"],
    &["lib.rs"],
];

const LAB: Layers = &[
    &["seeds.rs", "work.rs"],
    &["evaluator.rs", "fake_work.rs"],
    &["peers/", "evolution/", "comparison/"],
    &["wire/"],
    &["pool.rs", "csv.rs", "figures/", "report/"],
    &["offline/"],
    &["lib.rs"],
];

const API: Layers = &[
    &["visible.rs", "named.rs", "number.rs", "schema.rs"],
    &["problem/"],
    &["check.rs", "checked.rs", "id.rs", "idempotency.rs", "token.rs"],
    &["body/", "page.rs", "built_in.rs"],
    &[
        "robot/",
        "robot_check/",
        "square/",
        "task.rs",
        "step/",
        "stop.rs",
        "watch.rs",
        "health.rs",
        "estimate.rs",
    ],
    &["job/"],
    &["evolution/", "comparison/", "prior.rs", "training/", "environment/", "event.rs"],
    &["endpoint/", "conversion/"],
    &["document/"],
    &["lib.rs"],
];

const SERVER: Layers = &[
    &["resource/"],
    &["store/"],
    &["library/"],
    &["fleet/"],
    &["jobs/"],
    &["http/"],
    &["program/"],
    &["lib.rs"],
    &["main.rs"],
];

const CLIENT: Layers = &[
    &["error.rs", "address.rs", "token.rs"],
    &["call.rs", "connection.rs", "retry.rs", "pages.rs", "sse.rs"],
    &["step.rs"],
    &["client.rs", "compare/", "events/", "evolve/", "job.rs", "whole.rs"],
    &["lib.rs"],
    &["cli/"],
    &["main.rs"],
];

const AGENT: Layers = &[
    &["clock.rs", "epoch.rs", "throttle.rs", "log.rs", "on_the_way.rs", "told.rs"],
    &["drive/", "limits.rs", "transport.rs", "restraint.rs"],
    &["report.rs"],
    &["robot.rs"],
    &["agent.rs"],
    &["options/"],
    &["lib.rs"],
    &["main.rs"],
];

const TESTS: Layers = &[
    &["wait.rs", "data.rs", "trace.rs", "tap.rs"],
    &["http.rs", "process.rs", "proxy.rs", "rover.rs", "server.rs"],
    &["said.rs"],
    &["faults/"],
    &["lib.rs"],
];

/// The imports from a file by one of a higher layer, one line each.
pub fn upward(graph: &Graph, layers: Layers) -> Vec<String> {
    let is_upward = |from, to| match (rank(layers, from), rank(layers, to)) {
        (Some(from), Some(to)) => from < to,
        _ => false,
    };
    let upward = graph.edges().filter(|(from, to, _)| is_upward(from, to));
    upward.map(|(from, to, names)| line(from, to, names)).collect()
}

/// Which layer a file belongs to.
pub fn rank(layers: Layers, file: &str) -> Option<usize> {
    let entries = layers.iter().enumerate();
    let entries = entries.flat_map(|(rank, layer)| layer.iter().map(move |entry| (rank, *entry)));
    let is_of = |entry: &str| file == entry || (entry.ends_with('/') && file.starts_with(entry));
    let own = entries.filter(|(_, entry)| is_of(entry));
    own.max_by_key(|(_, entry)| entry.len()).map(|(rank, _)| rank)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MADE_UP: Layers = &[&["a/low.rs"], &["a/"], &["b.rs", "c.rs"]];

    #[test]
    fn a_file_belongs_to_the_longest_entry() {
        let rank = |file| rank(MADE_UP, file);
        assert_eq!([rank("a/low.rs"), rank("a/mod.rs"), rank("c.rs")], [Some(0), Some(1), Some(2)]);
        assert_eq!([rank("a.rs"), rank("b.rs/x.rs")], [None, None]);
    }

    #[test]
    fn upward_is_to_a_higher_layer_only() {
        let mut graph = Graph::default();
        for (from, to) in [("a/low.rs", "a/x.rs"), ("a/x.rs", "a/low.rs"), ("b.rs", "c.rs")] {
            graph.add(from, to, "Name");
        }
        assert_eq!(upward(&graph, MADE_UP), ["    a/low.rs -> a/x.rs: Name\n"]);
    }
}
