//! Jobs as tests submit them and follow them to their end.

use crate::api::{Answer, Api, JSON, config};
use crate::events::Stream;
use serde_json::Value;
use std::sync::Arc;
use std::time::Duration;
use umwelt_server::{Config, Priority, Server, Store};

/// Far above what anything here takes, on whatever machine.
const TIMEOUT: Duration = Duration::from_secs(120);

/// Evolutions as on a machine of their own: at the lowest priority they would wait for everything that is compiled
/// beside the tests.
pub(crate) fn hurried() -> Config {
    Config { evolution_threads: Some(2), evolution_priority: Priority::Normal, ..config() }
}

pub(crate) async fn serve(store: Arc<dyn Store>) -> Api {
    Api::with(hurried(), store).await
}

impl Api {
    pub(crate) async fn submit(&self, body: &Value) -> Answer {
        self.call("POST", "/v1/evolutions", &[JSON], body.to_string()).await
    }

    /// Submits an evolution and returns its path.
    pub(crate) async fn begin(&self, body: &Value) -> String {
        let answer = self.submit(body).await;
        assert_eq!(answer.code, 201, "{}", String::from_utf8_lossy(&answer.bytes));
        answer.headers["location"].to_str().unwrap().to_owned()
    }
}

/// A follower of an evolution or a comparison.
pub(crate) struct Follower(Stream);

impl Follower {
    pub(crate) async fn open(api: &Api, path: &str, after: Option<u64>) -> Self {
        Self(Stream::open(api, &format!("{path}/events"), after).await)
    }

    /// The next event; none at the end of the stream.
    async fn next(&mut self) -> Option<Value> {
        let block = async {
            loop {
                let block = self.0.block().await?;
                if !block.starts_with(':') {
                    return Some(block);
                }
            }
        };
        let block = tokio::time::timeout(TIMEOUT, block).await.expect("an event, or the end")?;
        let field = |name: &str| block.lines().find_map(|line| line.strip_prefix(name));
        let event: Value = serde_json::from_str(field("data: ").unwrap()).unwrap();
        assert_eq!(field("event: ").unwrap(), event["type"]);
        let id = event["id"].to_string();
        // An evolution's state has no id in the stream: whoever resumes behind it would miss generations.
        let has_id = event["type"] == "generation" || event["comparison"].is_string();
        assert_eq!(field("id: "), has_id.then_some(id.as_str()));
        Some(event)
    }

    /// The first event that is as it should be.
    pub(crate) async fn until(&mut self, is_right: impl Fn(&Value) -> bool) -> Value {
        loop {
            let event = self.next().await.expect("the stream goes on");
            if is_right(&event) {
                return event;
            }
        }
    }

    /// All that is left of the stream.
    pub(crate) async fn rest(&mut self) -> Vec<Value> {
        let mut events = Vec::new();
        while let Some(event) = self.next().await {
            events.push(event);
        }
        events
    }
}

/// Waits for the end of an evolution or a comparison and shows it then.
pub(crate) async fn ended(api: &Api, path: &str) -> Value {
    Follower::open(api, path, None).await.rest().await;
    api.get(path).await.json()
}

/// A server on a real socket that is told to end.
pub(crate) async fn serve_and_stop(store: Arc<dyn Store>, until: impl AsyncFnOnce(Api)) {
    let server = Server::with_store(hurried(), store).await.unwrap();
    let api = Api(server.router());
    let (stop, stopped) = tokio::sync::oneshot::channel::<()>();
    let running = tokio::spawn(server.run(async { stopped.await.unwrap_or_default() }));
    until(api).await;
    drop(stop);
    tokio::time::timeout(TIMEOUT, running).await.unwrap().unwrap().unwrap();
}
