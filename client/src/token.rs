//! The secret that is sent with every request, and the file that holds it.

use crate::error::Error;
use reqwest::header::{AUTHORIZATION, HeaderMap, HeaderValue};
use std::fs::File;
use std::io::Read;
use std::path::Path;
use umwelt_api::{MAX_TOKEN, Token};

/// Most bytes of a file that are read: a token and white space around it.
const MAX_FILE: u64 = 4 * MAX_TOKEN as u64;

/// Reads the token in `file`: the one that the server was started with.
///
/// # Errors
/// [`Error::BadCall`] where there is none; it never repeats what the file holds.
pub fn read_token(file: &Path) -> Result<Token, Error> {
    let wrong = |why: String| Error::BadCall {
        what: format!("reading the token file {}", file.display()).into(),
        why: format!("{why}; use the file that the server was started with"),
    };
    let mut text = String::new();
    File::open(file)
        .and_then(|opened| opened.take(MAX_FILE).read_to_string(&mut text))
        .map_err(|error| wrong(error.to_string()))?;
    text.parse().map_err(|error: umwelt_api::InvalidToken| wrong(error.to_string()))
}

/// What every request carries: the token, marked so that no log shows it and HTTP/2 never puts it into a table.
pub(crate) fn headers(token: Option<&Token>) -> HeaderMap {
    let bearer = token.and_then(|token| {
        // The characters of a token are those of a header.
        let mut value = HeaderValue::try_from(format!("Bearer {}", token.secret())).ok()?;
        value.set_sensitive(true);
        Some((AUTHORIZATION, value))
    });
    HeaderMap::from_iter(bearer)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Client;
    use crate::test_server::{Server, json};
    use hyper::StatusCode;
    use std::sync::{Arc, Mutex};
    use umwelt_api::step::Request;

    const SECRET: &str = "0123456789abcdef";

    #[test]
    fn a_file_that_holds_no_token_is_a_wrong_call_which_does_not_repeat_it() {
        let directory = tempfile::tempdir().unwrap();
        let file = directory.path().join("token");
        std::fs::write(&file, format!("{SECRET}\n")).unwrap();
        assert_eq!(read_token(&file).unwrap().secret(), SECRET);
        for wrong in ["", "hunter2", "hunter2 is no token at all"] {
            std::fs::write(&file, wrong).unwrap();
            let said = read_token(&file).unwrap_err().to_string();
            assert!(!said.contains("hunter2") && said.contains("a token"), "{said}");
        }
        let missing = read_token(&directory.path().join("none")).unwrap_err();
        assert!(matches!(&missing, Error::BadCall { what, .. } if what.contains("none")));
    }

    /// Guards against one kind of request, a stop of all things, that goes out without it.
    #[tokio::test]
    async fn every_request_carries_the_token_and_no_redirect_takes_it_elsewhere() {
        let elsewhere = Server::start(|_| async { json(StatusCode::OK, "{}") }).await;
        let seen = Arc::new(Mutex::new(Vec::new()));
        let server = {
            let (seen, location) = (Arc::clone(&seen), elsewhere.url.clone());
            Server::start(move |request| {
                let bearer = request.headers().get("authorization").cloned();
                seen.lock().unwrap().push(bearer.map(|value| value.to_str().unwrap().to_owned()));
                let mut answer = json(StatusCode::TEMPORARY_REDIRECT, "{}");
                answer.headers_mut().insert("location", location.parse().unwrap());
                async { answer }
            })
            .await
        };
        let token: Token = SECRET.parse().unwrap();
        for (token, expected) in [(Some(token), Some(format!("Bearer {SECRET}"))), (None, None)] {
            let client = Client::authorized(&server.url, token).unwrap();
            let robot = "r".parse().unwrap();
            let request = Request {
                sequence: 1,
                epoch: 1,
                sent_s: 0.0,
                observations: Vec::new(),
                deliveries: Vec::new(),
                playing: None,
                hold: false,
                max_speed_m_per_s: None,
                drive_tag: None,
            };
            assert!(client.stop_all().await.is_err());
            assert!(client.get_robot(&robot).await.is_err());
            assert!(client.events(None, None).await.is_err());
            assert!(client.step_connection().step(&robot, &request).await.is_err());
            assert_eq!(*seen.lock().unwrap(), vec![expected; 4]);
            seen.lock().unwrap().clear();
            assert!(!format!("{client:?} {:?}", client.step_connection()).contains(SECRET));
        }
        assert_eq!(elsewhere.requests(), 0);
    }
}
