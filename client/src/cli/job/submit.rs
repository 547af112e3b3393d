//! What `umwelt evolve` and `umwelt compare` do alike.

use super::super::failure::Failure;
use super::super::output::Output;
use super::super::progress::{say, wait};
use super::watch::watch;
use super::{Noun, accepted, refused};
use clap::Args;
use umwelt_api::IdempotencyKey;
use umwelt_client::{Client, fresh_key};

/// How to submit a job.
#[derive(Debug, Args)]
pub(in super::super) struct Submit {
    /// Submit it once, however often this is run with the same key; a random one otherwise
    #[arg(long, value_name = "KEY")]
    idempotency_key: Option<IdempotencyKey>,
    /// Show progress until it has ended, then its result
    #[arg(long)]
    pub(in super::super) watch: bool,
}

impl Submit {
    /// Submits what is asked for; shows that it was submitted, or watches it.
    pub(in super::super) async fn run<K: Noun>(
        self,
        client: &Client,
        output: &mut Output,
        request: &K::Request,
    ) -> Result<(), Failure> {
        let key = self.idempotency_key.unwrap_or_else(fresh_key);
        let submitted = wait(client.submit::<K>(request, Some(&key))).await;
        let job = submitted.map_err(|error| refused(error, &key))?;
        if !self.watch {
            return output.result(&job, accepted);
        }
        say(&accepted(&job));
        watch(client, output, &job).await
    }
}
