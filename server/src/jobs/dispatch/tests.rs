//! What all jobs go through, in the life of work without robots.

use super::*;
use crate::jobs::fake_work::{FakeSettings, FakeWork};
use crate::jobs::{Jobs, Limits, Submission};
use crate::store::{Contents, Keeper, MemoryStore, Store};
use umwelt_lab::pool::{Pool, Priority};
use umwelt_lab::work::Work as _;

async fn open(store: &Arc<MemoryStore>) -> Jobs<FakeWork> {
    let pool = Arc::new(Pool::new(Some(2), Priority::Normal).unwrap());
    let (limits, keeper) = (Limits { queued: 16, kept: 200 }, Keeper::new(store.clone()));
    let contents = store.load().unwrap();
    Jobs::open(limits, pool, keeper, (), &contents, &Default::default()).await.unwrap()
}

async fn submit(jobs: &Jobs<FakeWork>, settings: FakeSettings) -> Arc<Job<FakeWork>> {
    let submission = Submission { settings, key: None, request: String::new() };
    jobs.submitting().await.submit(submission, |number| Ok((number, ()))).await.unwrap()
}

async fn ended(job: &Job<FakeWork>) -> (State, Option<String>) {
    let record = job.follow().wait_for(|shown| shown.has_ended()).await.unwrap().record.clone();
    (record.state, record.error.clone())
}

/// Guards against one job that panics and takes the server with it, or all that wait.
#[tokio::test]
async fn a_job_that_panics_fails_and_the_next_has_its_turn() {
    let jobs = open(&Arc::default()).await;
    let panics = FakeSettings { panics: true, ..FakeSettings::default() };
    let (state, error) = ended(&*submit(&jobs, panics).await).await;
    assert_eq!(state, State::Failed);
    assert_eq!(error.unwrap(), "an evaluation failed: no floor under the robot");
    assert_eq!(
        ended(&*submit(&jobs, FakeSettings::default()).await).await,
        (State::Succeeded, None)
    );
}

/// Guards against work that asks for nothing more has no report, and keeps its turn for ever.
#[tokio::test]
async fn a_job_that_cannot_succeed_fails_with_its_reason_and_keeps_what_it_has_left() {
    let store = Arc::default();
    let jobs = open(&store).await;
    let fails = FakeSettings { batches: 2, fails: true, ..FakeSettings::default() };
    let job = submit(&jobs, fails).await;
    let reason = "it counts no further".to_owned();
    assert_eq!(ended(&job).await, (State::Failed, Some(reason)));
    assert_eq!(store.parts(job.id(), 0, 9).unwrap().len(), 2);
    assert_eq!(job.shown().record.reached.stage, Some(2));
    assert_eq!(
        ended(&*submit(&jobs, FakeSettings::default()).await).await,
        (State::Succeeded, None)
    );
}

/// Guards against a report without what the last batch has left.
#[tokio::test]
async fn what_the_last_batch_leaves_is_kept_with_the_report() {
    let store = Arc::default();
    let jobs = open(&store).await;
    let job = submit(&jobs, FakeSettings { batches: 3, ..FakeSettings::default() }).await;
    assert_eq!(ended(&job).await, (State::Succeeded, None));
    let Contents { jobs: stored, .. } = store.load().unwrap();
    assert!(stored[0].finished && stored[0].body.contains(r#""state":"succeeded""#));
    let indices: Vec<_> =
        store.parts(job.id(), 0, 9).unwrap().iter().map(|part| part.index).collect();
    assert_eq!(indices, [0, 1, 2]);
    assert_eq!(store.checkpoint(job.id()).unwrap(), None);
}

/// Guards against a job that begins anew after every restart, and never ends where those come often.
#[tokio::test]
async fn a_job_goes_on_from_its_checkpoint() {
    let store = Arc::default();
    let settings = FakeSettings { batches: 3, ..FakeSettings::default() };
    let before = open(&store).await;
    let fresh = submit(&before, settings).await;
    ended(&fresh).await;
    let shown = fresh.shown().record;
    let mut work = FakeWork::new(settings).unwrap();
    // What no batch of its own would have come to.
    work.tell(&[1_000_000]).unwrap();
    let checkpoint = Checkpoint { work, latest: None, elapsed: 7.0 };
    let record = Record { state: State::Running, report: None, ..(*shown).clone() };
    let [id, next] = [fresh.id().number, 9].map(|number| JobId { kind: FakeWork::KIND, number });
    let body = checkpoint.body().unwrap();
    store
        .commit(vec![
            Change::DeleteJob(id),
            Change::PutJob(record.stored(next).unwrap()),
            Change::PutCheckpoint { job: next, body },
        ])
        .unwrap();
    let after = open(&store).await;
    let resumed = after.find("counting-9").unwrap();
    assert_eq!(ended(&resumed).await, (State::Succeeded, None));
    let now = resumed.shown().record;
    assert!(now.report > Some(1_000_000) && shown.report < Some(1_000_000), "{now:?}");
    assert!(now.reached.elapsed >= 7.0 && now.interrupted == 1);
}
