use super::*;
use crate::store::JobId;
use crate::store::StoredKind;
use axum::http::{HeaderMap, StatusCode, header};
use std::sync::mpsc;

fn name(number: u64) -> Name {
    Name { job: JobId { kind: StoredKind::Comparison, number }, what: "figure", state: 0 }
}

async fn nothing() -> Result<(), Failure> {
    Ok(())
}

/// A document of so many bytes, counted when it is made.
async fn get(
    documents: &Documents,
    number: u64,
    bytes: usize,
    made: &Arc<AtomicUsize>,
) -> Document {
    let made = Arc::clone(made);
    let make = move |()| {
        made.fetch_add(1, Ordering::Relaxed);
        Ok("x".repeat(bytes))
    };
    documents.get(name(number), "text/plain", nothing(), make).await.unwrap()
}

/// Guards against: as many drawings as requests.
#[tokio::test]
async fn however_many_ask_it_is_made_once() {
    let (documents, made) = (Documents::new(1000), Arc::default());
    let all =
        futures_util::future::join_all((0..100).map(|_| get(&documents, 1, 100, &made))).await;
    get(&documents, 1, 100, &made).await;
    assert_eq!(made.load(Ordering::Relaxed), 1);
    let at = all[0].bytes.as_ptr();
    assert!(all.iter().all(|document| document.bytes.as_ptr() == at), "the same bytes for all");
}

#[tokio::test]
async fn those_that_were_asked_for_last_are_kept_up_to_the_limit() {
    let (documents, made) = (Documents::new(250), Arc::new(AtomicUsize::new(0)));
    let count = || made.load(Ordering::Relaxed);
    for number in [1, 2, 1, 3] {
        get(&documents, number, 100, &made).await;
    }
    assert_eq!(count(), 3);
    get(&documents, 1, 100, &made).await;
    assert_eq!(count(), 3, "it was asked for after the second one");
    get(&documents, 2, 100, &made).await;
    assert_eq!(count(), 4, "that one had made room");
    get(&documents, 4, 1000, &made).await;
    assert!(documents.0.alive.load(Ordering::Relaxed) <= 250, "what is too large is not kept");
}

/// Guards against: a hundred drawings at the same time, on all cores and in all memory.
#[tokio::test]
async fn two_are_made_at_a_time_a_bounded_number_waits_and_the_rest_is_told_so() {
    let documents = Documents::new(1000);
    let (go, gate) = mpsc::channel::<()>();
    let gate = Arc::new(Mutex::new(gate));
    let (running, most) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicUsize::new(0)));
    let asking = (0..40).map(|number| {
        let (gate, running, most) = (Arc::clone(&gate), Arc::clone(&running), Arc::clone(&most));
        let documents = documents.clone();
        tokio::spawn(async move {
            let make = move |()| {
                most.fetch_max(running.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
                // Until the test lets it go on.
                let _ = gate.lock().map(|gate| gate.recv());
                running.fetch_sub(1, Ordering::SeqCst);
                Ok(String::new())
            };
            documents.get(name(number), "text/plain", nothing(), make).await
        })
    });
    let asking: Vec<_> = asking.collect();
    while documents.0.waiting.available_permits() > 0 {
        tokio::task::yield_now().await;
    }
    for _ in 0..WAITING {
        go.send(()).unwrap();
    }
    let answers = futures_util::future::join_all(asking).await;
    let refused = answers.iter().filter(|answer| matches!(answer, Ok(Err(_)))).count();
    assert_eq!(refused, 40 - WAITING);
    assert!(most.load(Ordering::SeqCst) <= AT_A_TIME, "{most:?}");
    // Who was refused gets it later.
    go.send(()).unwrap();
    let make = |()| Ok("late".to_owned());
    assert_eq!(documents.get(name(39), "text/plain", nothing(), make).await.unwrap().bytes, "late");
}

#[tokio::test]
async fn a_failure_and_a_panic_are_told_and_the_next_one_tries_anew() {
    let documents = Documents::new(1000);
    let fail = |()| Err(failure::internal("no ink"));
    assert!(documents.get(name(1), "text/plain", nothing(), fail).await.is_err());
    let broken = |()| panic!("no paper");
    assert!(documents.get(name(1), "text/plain", nothing(), broken).await.is_err());
    let missing = async { Err::<(), _>(failure::internal("nothing is kept")) };
    assert!(documents.get(name(1), "text/plain", missing, |()| Ok(String::new())).await.is_err());
    assert!(get(&documents, 1, 10, &Arc::default()).await.bytes.len() == 10);
}

/// Guards against: who goes away takes a document along that took long to make.
#[tokio::test]
async fn it_is_made_to_the_end_when_no_one_waits_any_more() {
    let (documents, made) = (Documents::new(1000), Arc::default());
    let _ = futures_util::FutureExt::now_or_never(get(&documents, 1, 100, &made));
    let again = get(&documents, 1, 100, &made).await;
    assert_eq!((again.bytes.len(), made.load(Ordering::Relaxed)), (100, 1));
}

#[tokio::test]
async fn who_has_it_gets_it_no_second_time() {
    let document = get(&Documents::new(1000), 1, 5, &Arc::default()).await;
    let answer = |known: Option<&str>| {
        let mut headers = HeaderMap::new();
        if let Some(known) = known {
            headers.insert(header::IF_NONE_MATCH, known.parse().unwrap());
        }
        document.answer(&headers)
    };
    let first = answer(None);
    assert_eq!(
        (first.status(), &first.headers()["content-type"]),
        (StatusCode::OK, &"text/plain".parse().unwrap())
    );
    let etag = first.headers()["etag"].to_str().unwrap().to_owned();
    for known in [etag.clone(), format!("W/{etag}"), format!("\"other\", {etag}"), "*".to_owned()] {
        let response = answer(Some(&known));
        assert_eq!(response.status(), StatusCode::NOT_MODIFIED, "{known}");
        assert_eq!(response.headers()["etag"], etag);
    }
    for unknown in ["\"other\"", "", etag.trim_matches('"')] {
        assert_eq!(answer(Some(unknown)).status(), StatusCode::OK, "{unknown}");
    }
}

#[cfg(target_os = "linux")]
#[tokio::test]
async fn it_is_made_by_a_thread_that_gives_way() {
    let niceness = |()| {
        // proc_pid_stat(5), field 19.
        let stat = std::fs::read_to_string("/proc/thread-self/stat").unwrap();
        let after_name = stat.rsplit_once(')').unwrap().1;
        Ok(after_name.split_whitespace().nth(19 - 3).unwrap().to_owned())
    };
    let document = Documents::new(1000).get(name(1), "text/plain", nothing(), niceness).await;
    assert_eq!(document.unwrap().bytes, NICENESS.to_string());
    let own = std::fs::read_to_string("/proc/thread-self/stat").unwrap();
    let own = own.rsplit_once(')').unwrap().1.split_whitespace().nth(19 - 3).unwrap().to_owned();
    assert_ne!(own, NICENESS.to_string(), "no other thread");
}
