//! What operators do to a robot at the same time.

use super::{describe, straight_to};
use umwelt_api::problem::Status;
use umwelt_api::robot::{Description, Spec};
use umwelt_client::Error;
use umwelt_tests::http;
use umwelt_tests::server::Server;

fn assert_is_mismatch(error: &Error) {
    assert_eq!(error.status(), Some(Status::Aborted), "{error}");
    assert_eq!(error.problem().unwrap().details[0].reason, "ETAG_MISMATCH", "{error}");
}

/// Guards against: two people describe a robot at once and one of them drives with the other's wheels.
#[tokio::test]
async fn what_has_changed_meanwhile_is_not_overwritten() {
    let server = Server::start();
    let client = &server.client;
    let robot = describe(client, "rover-7").await;
    let first = client.get_robot(&robot).await.unwrap();
    let mut mine = Spec::default();
    mine.drive.wheel_radius_m = 0.021;
    let changed =
        client.if_match(&first.etag).put_robot(&robot, &Description::from(&mine)).await.unwrap();
    assert_ne!(changed.etag, first.etag);
    let theirs = Spec { drift: true, ..Spec::default() };
    let error = client
        .if_match(&first.etag)
        .put_robot(&robot, &Description::from(&theirs))
        .await
        .unwrap_err();
    assert_is_mismatch(&error);
    assert_eq!(client.get_robot(&robot).await.unwrap().spec, mine);
    let error = client.if_match(&first.etag).delete_robot(&robot).await.unwrap_err();
    assert_is_mismatch(&error);
    client.if_match(&changed.etag).put_robot(&robot, &Description::from(&theirs)).await.unwrap();
    assert_eq!(client.get_robot(&robot).await.unwrap().spec, theirs);

    let task = client.set_task(&robot, &straight_to(0.3)).await.unwrap();
    client.set_task(&robot, &straight_to(0.4)).await.unwrap();
    let error = client.if_match(&task.etag).set_task(&robot, &straight_to(0.5)).await.unwrap_err();
    assert_is_mismatch(&error);
    assert_eq!(client.get_task(&robot).await.unwrap().spec, straight_to(0.4));
}

/// Guards against: the version in the header is not the one in the body, and neither can be sent back.
#[tokio::test]
async fn the_version_in_the_header_is_the_one_in_the_body() {
    let server = Server::start();
    let path = "/v1/robots/rover-7";
    let created = http::call(server.address, "PUT", path, &[], b"{}").await;
    assert_eq!(created.code, 201, "{created:?}");
    let replaced = http::call(server.address, "PUT", path, &[], b"{\"drift\": true}").await;
    assert_eq!(replaced.code, 200, "{replaced:?}");
    let shown = http::call(server.address, "GET", path, &[], b"").await;
    let header = shown.header("etag").unwrap();
    let body = shown.json();
    assert_eq!(Some(header.trim_matches('"')), body["etag"].as_str(), "{shown:?}");
    assert_eq!(replaced.header("etag"), Some(header));
    assert_ne!(created.header("etag"), Some(header));
    let quoted = http::call(server.address, "PUT", path, &[("If-Match", header)], b"{}").await;
    assert_eq!(quoted.code, 200, "{quoted:?}");
    let again = http::call(server.address, "PUT", path, &[("If-None-Match", "*")], b"{}").await;
    assert_eq!(again.code, 412, "{again:?}");
    let removed = http::call(server.address, "DELETE", path, &[], b"").await;
    assert_eq!((removed.code, removed.body.as_str()), (204, ""));
    let gone = http::call(server.address, "GET", path, &[], b"").await;
    assert_eq!(gone.code, 404, "{gone:?}");
}
