//! What is not yet as it should be, per package. The lists only become shorter: what is new fails, and so does an entry
//! that is no longer true.

/// Circles of imports: the files of each, below `src`.
pub const CIRCLES: &[(&str, &[&[&str]])] = &[
    (
        "umwelt-lab",
        &[&[
            "comparison/bootstrap.rs",
            "comparison/contender.rs",
            "comparison/mod.rs",
            "comparison/report.rs",
            "comparison/scenario.rs",
            "comparison/settings.rs",
        ]],
    ),
    ("umwelt-api", &[&["comparison/claim.rs", "comparison/report.rs"]]),
    (
        "umwelt-server",
        &[
            &["jobs/dispatch.rs", "jobs/job.rs", "jobs/queue.rs"],
            &["jobs/record.rs", "jobs/work.rs"],
        ],
    ),
];

/// Files of 400 lines and more.
pub const LONG: &[(&str, &[&str])] = &[];
