//! What `umwelt evolution` and `umwelt comparison` do alike.

use super::super::failure::Failure;
use super::super::output::Output;
use super::super::progress::{say, wait};
use super::super::unreadable::with;
use super::Noun;
use super::watch;
use serde_json::json;
use umwelt_api::job::{Job, JobPage, State};
use umwelt_client::Client;

/// Lists jobs, the newest first; those in one state where one is given.
pub(in super::super) async fn list<K: Noun>(
    client: &Client,
    output: &mut Output,
    state: Option<State>,
) -> Result<(), Failure> {
    let page: JobPage<K> = wait(client.whole(state.map(State::name))).await?;
    if page.jobs.is_empty() {
        say(&format!("no {}; submit one: umwelt {}", K::LIST, K::VERB));
    }
    output.result(&page, listed)
}

/// A table of jobs, with what cannot be read below it.
pub(in super::super) fn listed<K: Noun>(page: &JobPage<K>) -> String {
    let table = if page.jobs.is_empty() { String::new() } else { K::table(&page.jobs) };
    with(table, &page.unreadable)
}

/// Shows a job.
pub(in super::super) async fn show<K: Noun>(
    client: &Client,
    output: &mut Output,
    id: &K::Id,
) -> Result<(), Failure> {
    output.result(&wait(client.job::<K>(id)).await?, K::show)
}

/// Watches a job until it has ended.
pub(in super::super) async fn watch<K: Noun>(
    client: &Client,
    output: &mut Output,
    id: &K::Id,
) -> Result<(), Failure> {
    let job: Job<K> = wait(client.job(id)).await?;
    watch::watch(client, output, &job).await
}

/// Cancels a job.
pub(in super::super) async fn cancel<K: Noun>(
    client: &Client,
    output: &mut Output,
    id: &K::Id,
) -> Result<(), Failure> {
    let cancelled = wait(client.cancel::<K>(id)).await?;
    output.result(&cancelled, |it| format!("{} is cancelled", it.id))
}

/// Removes a job that has ended.
pub(in super::super) async fn remove<K: Noun>(
    client: &Client,
    output: &mut Output,
    id: &K::Id,
) -> Result<(), Failure> {
    wait(client.remove::<K>(id)).await?;
    output.result(&json!({ K::NAME: id, "removed": true }), |_| format!("{id} is removed"))
}
