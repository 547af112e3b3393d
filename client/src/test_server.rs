//! A server for the tests of this crate: one closure, HTTP/1 and HTTP/2 on a loopback socket.

use http_body_util::combinators::BoxBody;
use http_body_util::{BodyExt, Full};
use hyper::body::{Bytes, Incoming};
use hyper::service::service_fn;
use hyper::{Request, Response, StatusCode, header};
use hyper_util::rt::{TokioExecutor, TokioIo};
use hyper_util::server::conn::auto;
use std::convert::Infallible;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use tokio::net::TcpListener;
use tokio::sync::mpsc;

pub(crate) type Body = BoxBody<Bytes, Infallible>;

/// The server; it ends with the runtime of its test.
pub(crate) struct Server {
    pub(crate) url: String,
    connections: Arc<AtomicUsize>,
    requests: Arc<AtomicUsize>,
    ended: mpsc::UnboundedReceiver<()>,
}

impl Server {
    /// Answers every request with `answer`.
    pub(crate) async fn start<F>(
        answer: impl Fn(Request<Incoming>) -> F + Clone + Send + 'static,
    ) -> Self
    where
        F: Future<Output = Response<Body>> + Send + 'static,
    {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let url = format!("http://{}", listener.local_addr().unwrap());
        let (connections, requests) = (Arc::default(), Arc::default());
        let (end, ended) = mpsc::unbounded_channel();
        let server = Self {
            url,
            connections: Arc::clone(&connections),
            requests: Arc::clone(&requests),
            ended,
        };
        tokio::spawn(async move {
            loop {
                let (socket, _) = listener.accept().await.unwrap();
                connections.fetch_add(1, Ordering::SeqCst);
                let (answer, requests, end) = (answer.clone(), Arc::clone(&requests), end.clone());
                tokio::spawn(async move {
                    let service = service_fn(move |request| {
                        requests.fetch_add(1, Ordering::SeqCst);
                        let answer = answer(request);
                        async { Ok::<_, Infallible>(answer.await) }
                    });
                    let http = auto::Builder::new(TokioExecutor::new());
                    // How the connection ended is the client's business.
                    let _ = http.serve_connection(TokioIo::new(socket), service).await;
                    let _ = end.send(());
                });
            }
        });
        server
    }

    /// Waits until a connection has ended.
    pub(crate) async fn connection_ended(&mut self) {
        self.ended.recv().await.unwrap();
    }

    pub(crate) fn connections(&self) -> usize {
        self.connections.load(Ordering::SeqCst)
    }

    pub(crate) fn requests(&self) -> usize {
        self.requests.load(Ordering::SeqCst)
    }
}

/// An answer in JSON.
pub(crate) fn json(status: StatusCode, body: &str) -> Response<Body> {
    answer(status, "application/json", body)
}

/// A whole answer of some kind.
pub(crate) fn answer(status: StatusCode, kind: &str, body: &str) -> Response<Body> {
    let mut response = Response::new(Full::new(Bytes::from(body.to_owned())).boxed());
    *response.status_mut() = status;
    response.headers_mut().insert(header::CONTENT_TYPE, kind.parse().unwrap());
    response
}
