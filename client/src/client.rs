//! The typed client: one method per route.

use crate::address::Address;
use crate::call::{self, Call, Condition};
use crate::connection;
use crate::error::Error;
use crate::pages;
use crate::retry::{MAX_RETRIES, Unavailable};
use crate::step::StepConnection;
use bytes::Bytes;
use futures_util::stream::BoxStream;
use reqwest::{Method, Url};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::sync::Arc;
use std::time::Duration;
use tower::retry::RetryLayer;
use tower::util::BoxCloneSyncService;
use tower::{Service, ServiceBuilder, ServiceExt};
use umwelt_api::endpoint::{self, Endpoint};
use umwelt_api::environment::Environment;
use umwelt_api::health::Health;
use umwelt_api::page::PageQuery;
use umwelt_api::robot::{self, MAX_PAGE_SIZE, Page, Robot};
use umwelt_api::stop::{Stop, StopAll};
use umwelt_api::task::{self, Task};
use umwelt_api::{RobotId, Token};

/// Time for a call with its retries: a bad link's worst silence of 12 s is not waited out, a person asks again.
pub const DEADLINE: Duration = Duration::from_secs(10);

/// An Umwelt server, as seen from here. Cheap to clone; clones share their connections.
///
/// Calls that the server refuses as UNAVAILABLE are sent again, within the deadline and its `Retry-After`; nothing
/// else ever is. Every call takes at most [`DEADLINE`] or what [`Client::within`] says.
///
/// ```no_run
/// # async fn example() -> Result<(), Box<dyn std::error::Error>> {
/// use umwelt_api::robot::Description;
/// let client = umwelt_client::Client::new("http://127.0.0.1:8080")?;
/// let said = Description::read(br#"{"drive": {"wheel_radius_m": 0.033}}"#)?;
/// let rover = client.put_robot(&"rover-7".parse()?, &said).await?;
/// println!("{} is {:?}", rover.robot, rover.state);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct Client {
    address: Address,
    token: Option<Token>,
    allowed: Duration,
    condition: Condition,
    http: reqwest::Client,
    calls: Calls,
}

/// The stack: built and boxed once, because every layer in its type is paid for at every call site.
type Calls = BoxCloneSyncService<Call, Bytes, Error>;

/// Retry over one attempt. Each attempt ends at the deadline of the call, which all of them share.
pub(crate) fn stack<S>(attempt: S) -> Calls
where
    S: Service<Call, Response = Bytes, Error = Error> + Clone + Send + Sync + 'static,
    S::Future: Send,
{
    let retried =
        ServiceBuilder::new().layer(RetryLayer::new(Unavailable::default())).service(attempt);
    BoxCloneSyncService::new(retried)
}

impl Client {
    /// A client of the server at `base_url`, as `http://127.0.0.1:8080`. Nothing is sent yet.
    ///
    /// # Errors
    /// [`Error::BadCall`] where `base_url` is no such address.
    pub fn new(base_url: &str) -> Result<Self, Error> {
        Self::authorized(base_url, None)
    }

    /// The same with the server's token, where it has one: every request carries it.
    ///
    /// # Errors
    /// [`Error::BadCall`] where `base_url` is no such address.
    pub fn authorized(base_url: &str, token: Option<Token>) -> Result<Self, Error> {
        let http = connection::http(reqwest::Client::builder(), token.as_ref());
        let attempt = {
            let http = http.clone();
            tower::service_fn(move |call| call::send(http.clone(), call))
        };
        let address = Address::read(base_url)?;
        let calls = stack(attempt);
        Ok(Self { address, token, allowed: DEADLINE, condition: Condition::None, http, calls })
    }

    /// The same client with another deadline for its calls.
    pub fn within(&self, deadline: Duration) -> Self {
        Self { allowed: deadline, ..self.clone() }
    }

    /// The same client, whose PUTs, PATCHes and DELETEs are done only if the resource still has this etag; ABORTED otherwise.
    pub fn if_match(&self, etag: &str) -> Self {
        Self { condition: Condition::Version(etag.into()), ..self.clone() }
    }

    /// The same client, whose PUTs are done only where there is nothing yet; ALREADY_EXISTS otherwise.
    pub fn if_absent(&self) -> Self {
        Self { condition: Condition::Absent, ..self.clone() }
    }

    /// A connection for steps. It is opened by the first step and shared with nothing else.
    pub fn step_connection(&self) -> StepConnection {
        StepConnection::new(self.address.clone(), self.token.as_ref())
    }

    /// Describes a robot, for the first time or anew: what is not said is default, or follows from the rest.
    ///
    /// # Errors
    /// Whatever [`Error`] tells.
    pub async fn put_robot(
        &self,
        robot: &RobotId,
        said: &robot::Description,
    ) -> Result<Robot, Error> {
        self.send(endpoint::PUT_ROBOT, &[robot.as_str()], said).await
    }

    /// Changes parts of what was said about a robot.
    ///
    /// # Errors
    /// NOT_FOUND where it is not known, and whatever [`Error`] tells.
    pub async fn patch_robot(&self, robot: &RobotId, patch: &robot::Patch) -> Result<Robot, Error> {
        self.send(endpoint::PATCH_ROBOT, &[robot.as_str()], patch).await
    }

    /// The robot as it is now.
    ///
    /// # Errors
    /// NOT_FOUND where it is not known, and whatever [`Error`] tells.
    pub async fn get_robot(&self, robot: &RobotId) -> Result<Robot, Error> {
        self.ask(endpoint::GET_ROBOT, &[robot.as_str()]).await
    }

    /// Removes a robot with its task and what was learned.
    ///
    /// # Errors
    /// NOT_FOUND where it is not known, and whatever [`Error`] tells.
    pub async fn delete_robot(&self, robot: &RobotId) -> Result<(), Error> {
        self.perform(endpoint::DELETE_ROBOT, &[robot.as_str()]).await
    }

    /// One page of the robots, in the order of their ids. [`Client::robots`] walks over all pages.
    ///
    /// # Errors
    /// Whatever [`Error`] tells.
    pub async fn list_robots(&self, query: &PageQuery<robot::State>) -> Result<Page, Error> {
        self.page(self.url(endpoint::LIST_ROBOTS, &[]), query, |state| state.name()).await
    }

    /// All robots, or those in one state, in the order of their ids. Pages are asked for as they are needed; an
    /// error ends the stream.
    pub fn robots(&self, state: Option<robot::State>) -> BoxStream<'static, Result<Robot, Error>> {
        let query = PageQuery { page_size: Some(MAX_PAGE_SIZE), state, ..PageQuery::default() };
        let url = self.url(endpoint::LIST_ROBOTS, &[]);
        let split = |page: Page| (page.robots, page.next_page_token);
        self.all(url, query, |state| state.name(), split)
    }

    /// Sets the task of a robot; it begins with the next step and replaces the one before. The very task that it has
    /// already goes on as it is, arrived or not: to have it driven again, cancel it first.
    ///
    /// # Errors
    /// NOT_FOUND where the robot is not known, and whatever [`Error`] tells.
    pub async fn set_task(&self, robot: &RobotId, spec: &task::Spec) -> Result<Task, Error> {
        self.send(endpoint::PUT_TASK, &[robot.as_str()], spec).await
    }

    /// The task of a robot and how far it has got.
    ///
    /// # Errors
    /// NOT_FOUND where there is no such robot or it has no task, and whatever [`Error`] tells.
    pub async fn get_task(&self, robot: &RobotId) -> Result<Task, Error> {
        self.ask(endpoint::GET_TASK, &[robot.as_str()]).await
    }

    /// Cancels the task of a robot; it ramps to rest.
    ///
    /// # Errors
    /// NOT_FOUND where there is no such robot or it has no task, and whatever [`Error`] tells.
    pub async fn cancel_task(&self, robot: &RobotId) -> Result<(), Error> {
        self.perform(endpoint::DELETE_TASK, &[robot.as_str()]).await
    }

    /// What is identified of the floor and the link of a robot.
    ///
    /// # Errors
    /// NOT_FOUND where the robot is not known, and whatever [`Error`] tells.
    pub async fn environment(&self, robot: &RobotId) -> Result<Environment, Error> {
        self.ask(endpoint::GET_ENVIRONMENT, &[robot.as_str()]).await
    }

    /// Forgets what was learned about the environment of a robot: back to the prior.
    ///
    /// # Errors
    /// NOT_FOUND where the robot is not known, and whatever [`Error`] tells.
    pub async fn reset_environment(&self, robot: &RobotId) -> Result<Environment, Error> {
        self.ask(endpoint::RESET_ENVIRONMENT, &[robot.as_str()]).await
    }

    /// Stops a robot until it is resumed, from its next exchange on. Its task is kept.
    ///
    /// # Errors
    /// NOT_FOUND where the robot is not known, and whatever [`Error`] tells.
    pub async fn stop(&self, robot: &RobotId) -> Result<Stop, Error> {
        self.ask(endpoint::STOP_ROBOT, &[robot.as_str()]).await
    }

    /// Lets a stopped robot go on.
    ///
    /// # Errors
    /// NOT_FOUND where the robot is not known, and whatever [`Error`] tells.
    pub async fn resume(&self, robot: &RobotId) -> Result<Stop, Error> {
        self.ask(endpoint::RESUME_ROBOT, &[robot.as_str()]).await
    }

    /// Stops all robots until they are resumed.
    ///
    /// # Errors
    /// Whatever [`Error`] tells.
    pub async fn stop_all(&self) -> Result<StopAll, Error> {
        self.ask(endpoint::STOP_ALL, &[]).await
    }

    /// Lets all stopped robots go on.
    ///
    /// # Errors
    /// Whatever [`Error`] tells.
    pub async fn resume_all(&self) -> Result<StopAll, Error> {
        self.ask(endpoint::RESUME_ALL, &[]).await
    }

    /// Whether the server lives.
    ///
    /// # Errors
    /// Whatever [`Error`] tells.
    pub async fn health(&self) -> Result<Health, Error> {
        self.ask(endpoint::HEALTH, &[]).await
    }

    /// Whether the server takes requests. It is asked once: UNAVAILABLE is the answer here.
    ///
    /// # Errors
    /// UNAVAILABLE where it does not, and whatever [`Error`] tells.
    pub async fn ready(&self) -> Result<Health, Error> {
        let url = self.url(endpoint::READINESS, &[]);
        self.typed(Call::new(Method::GET, url, self.allowed, 0)).await
    }

    pub(crate) fn http(&self) -> &reqwest::Client {
        &self.http
    }

    pub(crate) fn allowed(&self) -> Duration {
        self.allowed
    }

    pub(crate) fn at(&self, path: &[&str]) -> Url {
        self.address.at(path)
    }

    /// Where an endpoint is asked that is about what these `names` say.
    pub(crate) fn url<B, A>(&self, endpoint: Endpoint<B, A>, names: &[&str]) -> Url {
        self.at(&endpoint.operation().segments(names))
    }

    /// What an endpoint answers.
    pub(crate) async fn ask<A: DeserializeOwned>(
        &self,
        endpoint: Endpoint<(), A>,
        names: &[&str],
    ) -> Result<A, Error> {
        self.typed(self.calling(endpoint, names)).await
    }

    /// What an endpoint answers to `body`.
    pub(crate) async fn send<B: Serialize, A: DeserializeOwned>(
        &self,
        endpoint: Endpoint<B, A>,
        names: &[&str],
        body: &B,
    ) -> Result<A, Error> {
        self.typed(self.calling(endpoint, names).with_json(body)?).await
    }

    /// Has an endpoint do what answers nothing.
    pub(crate) async fn perform(&self, endpoint: Endpoint, names: &[&str]) -> Result<(), Error> {
        self.bytes(self.calling(endpoint, names)).await.map(drop)
    }

    /// A call of an endpoint, on the condition of this client where it takes one.
    pub(crate) fn calling<B, A>(&self, endpoint: Endpoint<B, A>, names: &[&str]) -> Call {
        let operation = endpoint.operation();
        let method = match operation.method {
            endpoint::Method::Get => Method::GET,
            endpoint::Method::Put => Method::PUT,
            endpoint::Method::Patch => Method::PATCH,
            endpoint::Method::Post => Method::POST,
            endpoint::Method::Delete => Method::DELETE,
        };
        let condition = match &self.condition {
            Condition::Version(_) if !operation.is_conditional => Condition::None,
            Condition::Absent if operation.method != endpoint::Method::Put => Condition::None,
            condition => condition.clone(),
        };
        Call { condition, ..self.call(method, self.url(endpoint, names)) }
    }

    pub(crate) async fn get<T: DeserializeOwned>(&self, url: Url) -> Result<T, Error> {
        self.typed(self.call(Method::GET, url)).await
    }

    pub(crate) async fn post<T: DeserializeOwned>(&self, url: Url) -> Result<T, Error> {
        self.typed(self.call(Method::POST, url)).await
    }

    /// The page of the list at `url` that was asked for; `name` is that of a state.
    pub(crate) async fn page<P: DeserializeOwned, S>(
        &self,
        mut url: Url,
        query: &PageQuery<S>,
        name: fn(&S) -> &str,
    ) -> Result<P, Error> {
        pages::add_query(&mut url, query, name);
        self.get(url).await
    }

    /// All items of the list at `url` that `query` asks for, from its first page on; `split` takes a page apart. Pages
    /// are asked for as they are needed; an error ends the stream.
    pub(crate) fn all<P, S, T>(
        &self,
        url: Url,
        query: PageQuery<S>,
        name: fn(&S) -> &str,
        split: fn(P) -> pages::Page<T>,
    ) -> BoxStream<'static, Result<T, Error>>
    where
        P: DeserializeOwned + Send + 'static,
        S: Clone + Send + Sync + 'static,
        T: Send + 'static,
    {
        let client = self.clone();
        pages::all(format!("GET {url}"), move |page_token| {
            let (client, url) = (client.clone(), url.clone());
            let query = PageQuery { page_token, ..query.clone() };
            async move { Ok(split(client.page(url, &query, name).await?)) }
        })
    }

    pub(crate) async fn delete(&self, url: Url) -> Result<(), Error> {
        let call = self.call(Method::DELETE, url);
        let call = Call { condition: self.condition.clone(), ..call };
        self.bytes(call).await.map(drop)
    }

    pub(crate) fn call(&self, method: Method, url: Url) -> Call {
        Call::new(method, url, self.allowed, MAX_RETRIES)
    }

    pub(crate) async fn typed<T: DeserializeOwned>(&self, call: Call) -> Result<T, Error> {
        let what = Arc::clone(&call.what);
        let answer = self.bytes(call).await?;
        call::read(&what, &answer)
    }

    /// The answer as it comes.
    pub(crate) async fn bytes(&self, call: Call) -> Result<Bytes, Error> {
        self.calls.clone().oneshot(call).await
    }
}
