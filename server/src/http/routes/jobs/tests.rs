//! A third kind of job, of which no other code knows: it counts. It goes through the queue, the store, the wire and the
//! routes as evolutions and comparisons do.

use super::*;
use crate::Config;
use crate::jobs::fake_work::{FakeSettings, FakeWork};
use crate::jobs::{Limits, OnWire, Reached, Record};
use crate::program::serve::Server;
use crate::store::{Keeper, MemoryStore, Store, StoredKind};
use axum::Router;
use axum::body::Body as HttpBody;
use axum::extract::FromRef;
use axum::http::Method;
use axum::routing::{get as on_get, post as on_post};
use http_body_util::BodyExt;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use tower::ServiceExt;
use umwelt_api::job::{self, JobDescription, JobEvent, JobNews, State as WireState};
use umwelt_api::problem::ErrorBody;
use umwelt_api::schema::ToSchema;
use umwelt_api::{Check, Checked, PriorId, Validate, body};
use umwelt_lab::pool::{Pool, Priority};
use umwelt_lab::wire::Pace;

/// Countings among the jobs of the wire.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CountingKind;

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(default)]
pub(crate) struct Request {
    batches: u64,
}

impl Validate for Request {
    fn check(&self, check: &mut Check) {
        check.agrees("batches", self.batches > 0, self.batches, "count something");
    }
}

impl Body for Request {
    const MAX_BYTES: usize = 1024;

    fn read(json: &[u8]) -> Result<Checked<Self>, Problems> {
        body::read_resolved(json, |_: &Self, _| ()).map(|(request, ())| request)
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub(crate) struct Progress {
    batches: u64,
    episodes: u64,
    total_episodes: u64,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
pub(crate) struct Outcome {
    sum: Option<u64>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
pub(crate) enum News {
    State { state: WireState, progress: Progress, error: Option<String> },
}

impl JobNews<Progress> for News {
    fn of_state(state: WireState, progress: Progress, error: Option<String>) -> Self {
        Self::State { state, progress, error }
    }

    fn state(&self) -> Option<(WireState, &Progress)> {
        let Self::State { state, progress, .. } = self;
        Some((*state, progress))
    }

    fn name(&self) -> &'static str {
        "state"
    }
}

impl JobKind for CountingKind {
    const NAME: &'static str = "counting";
    const LIST: &'static str = "countings";
    const DESCRIPTION: JobDescription = JobDescription {
        job: "counting.Counting",
        page: "counting.Page",
        event: "counting.Event",
        one: "a counting",
        listed: "The countings.",
        event_id: "Batches.",
    };
    type Id = PriorId;
    type Request = Request;
    type Spec = Request;
    type Progress = Progress;
    type Outcome = Outcome;
    type News = News;

    fn id(number: u64) -> PriorId {
        format!("counting-{number}").parse().unwrap()
    }

    fn event_id(progress: &Progress) -> u64 {
        progress.batches
    }

    fn episodes(progress: &Progress) -> (u64, u64) {
        (progress.episodes, progress.total_episodes)
    }
}

impl OnWire for FakeWork {
    type Kind = CountingKind;

    fn wire_spec(record: &Record<Self>) -> Request {
        Request { batches: record.settings.batches as u64 }
    }

    fn progress(_: &FakeSettings, reached: &Reached<Self>, pace: Pace) -> Progress {
        let Pace { episodes, total_episodes, .. } = pace;
        Progress { batches: reached.stage.unwrap_or(0) as u64, episodes, total_episodes }
    }

    fn outcome(record: &Record<Self>) -> Outcome {
        Outcome { sum: record.report }
    }
}

impl Resource for FakeWork {
    fn read(_: &App, body: &[u8]) -> Result<(Checked<Request>, FakeSettings), Problems> {
        let request = Request::read(body)?;
        let batches = usize::try_from(request.batches).unwrap();
        Ok((request, FakeSettings { batches, micros: 100, ..FakeSettings::default() }))
    }

    fn own(_: &App, _: &Jobs<Self>, _: &Request, next: u64) -> Result<(u64, ()), Failure> {
        Ok((next, ()))
    }
}

/// What the routes of countings can reach.
#[derive(Clone)]
struct Reach {
    app: App,
    countings: Jobs<FakeWork>,
}

impl FromRef<Reach> for App {
    fn from_ref(reach: &Reach) -> Self {
        reach.app.clone()
    }
}

impl FromRef<Reach> for Jobs<FakeWork> {
    fn from_ref(reach: &Reach) -> Self {
        reach.countings.clone()
    }
}

async fn router(store: &Arc<MemoryStore>) -> Router {
    let config = Config { listen: ([127, 0, 0, 1], 0).into(), ..Config::default() };
    let app = Server::bind(config).await.unwrap().app();
    let pool = Arc::new(Pool::new(Some(2), Priority::Normal).unwrap());
    let (limits, keeper) = (Limits { queued: 16, kept: 200 }, Keeper::new(store.clone()));
    let contents = store.load().unwrap();
    let countings = Jobs::open(limits, pool, keeper, (), &contents, &app.unreadable).await.unwrap();
    Router::new()
        .route("/v1/countings", on_post(submit::<FakeWork>).get(list::<FakeWork>))
        .route("/v1/countings/{counting}", on_get(get::<FakeWork>).delete(delete::<FakeWork>))
        .route("/v1/countings/{counting}/cancel", on_post(cancel::<FakeWork>))
        .route("/v1/countings/{counting}/events", on_get(events::<FakeWork>))
        .with_state(Reach { app, countings })
}

/// The code and the body of an answer.
async fn ask(router: &Router, method: Method, path: &str, body: &str) -> (StatusCode, String) {
    let request = axum::http::Request::builder()
        .method(method)
        .uri(path)
        .header(header::CONTENT_TYPE, "application/json")
        .header(IdempotencyKey::HEADER, "key-1")
        .body(HttpBody::from(body.to_owned()))
        .unwrap();
    let answer = router.clone().oneshot(request).await.unwrap();
    let code = answer.status();
    let body = answer.into_body().collect().await.unwrap().to_bytes();
    (code, String::from_utf8(body.to_vec()).unwrap())
}

fn read<T: DeserializeOwned>(text: &str) -> T {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

type Counting = job::Job<CountingKind>;

#[tokio::test]
async fn a_third_kind_has_all_that_jobs_have() {
    let store = Arc::default();
    let router = router(&store).await;
    let (code, refused) = ask(&router, Method::POST, "/v1/countings", "{}").await;
    let problem = read::<ErrorBody>(&refused);
    assert_eq!((code, problem.error.details[0].field.as_str()), (StatusCode::CONFLICT, "batches"));

    let body = r#"{"batches": 3}"#;
    let (code, text) = ask(&router, Method::POST, "/v1/countings", body).await;
    assert_eq!(code, StatusCode::CREATED, "{text}");
    let counting: Counting = read(&text);
    assert_eq!((counting.id.as_str(), counting.spec.batches), ("counting-1", 3));
    assert_eq!(read::<Value>(&text)["counting"], "counting-1", "the id has the name of its kind");
    let (code, again) = ask(&router, Method::POST, "/v1/countings", body).await;
    assert_eq!((code, read::<Counting>(&again).id), (StatusCode::OK, counting.id));

    // The stream ends with the state in which the job has ended.
    let (_, stream) = ask(&router, Method::GET, "/v1/countings/counting-1/events", "").await;
    let last = stream.lines().filter_map(|line| line.strip_prefix("data: ")).next_back().unwrap();
    let last: JobEvent<CountingKind> = read(last);
    let (state, progress) = last.kind.state().unwrap();
    assert_eq!((state, progress.batches, last.id), (WireState::Succeeded, 3, 3));

    let (_, shown) = ask(&router, Method::GET, "/v1/countings/counting-1", "").await;
    let ended: Counting = read(&shown);
    // 0 + 2 + 6 + ... + 90 in each batch.
    assert_eq!((ended.state, ended.outcome.sum), (WireState::Succeeded, Some(3 * 330)));
    let (_, page) = ask(&router, Method::GET, "/v1/countings?state=succeeded", "").await;
    assert_eq!(read::<JobPage<CountingKind>>(&page).jobs, [ended]);
    let stored = store.load().unwrap().jobs;
    assert_eq!((stored[0].id.kind, stored[0].finished), (StoredKind::Counting, true));

    let (code, _) = ask(&router, Method::POST, "/v1/countings/counting-1/cancel", "").await;
    assert_eq!(code, StatusCode::CONFLICT, "it has succeeded");
    let (code, _) = ask(&router, Method::DELETE, "/v1/countings/counting-1", "").await;
    assert_eq!(code, StatusCode::NO_CONTENT);
    let (code, _) = ask(&router, Method::GET, "/v1/countings/counting-1", "").await;
    assert_eq!(code, StatusCode::NOT_FOUND);
    assert!(store.load().unwrap().jobs.is_empty());
}

#[tokio::test]
async fn a_third_kind_can_be_cancelled() {
    let router = router(&Arc::default()).await;
    let body = json!({"batches": 1_000_000}).to_string();
    let (code, text) = ask(&router, Method::POST, "/v1/countings", &body).await;
    assert_eq!(code, StatusCode::CREATED, "{text}");
    let (code, text) = ask(&router, Method::POST, "/v1/countings/counting-1/cancel", "").await;
    assert_eq!((code, read::<Counting>(&text).state), (StatusCode::OK, WireState::Cancelled));
}
