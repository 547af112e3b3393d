//! Repeated, late and reordered steps, and clocks that begin anew.

use super::{describe, straight_to};
use umwelt_api::problem::Status;
use umwelt_api::step::{Delivery, Request};
use umwelt_tests::rover::request;
use umwelt_tests::server::Server;

fn seen_at(x_m: f64, request: Request) -> Request {
    let mut request = request;
    request.observations[0].x_m = x_m;
    request
}

/// Guards against: a request that the link sends twice is driven twice, or gets another answer the second time.
#[tokio::test]
async fn a_repeat_gets_the_answer_that_it_got() {
    let server = Server::start();
    let robot = describe(&server.client, "rover-7").await;
    server.client.set_task(&robot, &straight_to(0.3)).await.unwrap();
    let steps = server.client.step_connection();
    let mut replies = Vec::new();
    for sequence in 1..=8 {
        let request = request(1, sequence, sequence as f64 * 0.03);
        replies.push(steps.step(&robot, &request).await.unwrap());
    }
    let before = server.client.get_robot(&robot).await.unwrap();
    // On another connection, in another order, with another content: the sequence is what counts.
    let other = server.client.step_connection();
    for sequence in [8, 3, 1, 3, 5] {
        let repeat = seen_at(5.0, request(1, sequence, 0.5));
        let again = other.step(&robot, &repeat).await.unwrap();
        assert_eq!(again, replies[sequence as usize - 1]);
    }
    let after = server.client.get_robot(&robot).await.unwrap();
    assert_eq!((after.pose, after.task), (before.pose, before.task));
    let link = server.client.environment(&robot).await.unwrap().link;
    assert_eq!(link.samples, 0);
}

/// Guards against: a packet that was held up brings back an old pose, or an old horizon with a new number.
#[tokio::test]
async fn a_late_step_teaches_the_link_and_changes_nothing_else() {
    let server = Server::start();
    let robot = describe(&server.client, "rover-7").await;
    server.client.set_task(&robot, &straight_to(0.3)).await.unwrap();
    let steps = server.client.step_connection();
    let at = |sequence: u64, x_m: f64| {
        let mut request = seen_at(x_m, request(1, sequence, sequence as f64 * 0.03));
        let loop_delay_s = 0.2 + sequence as f64 * 1e-3;
        request.deliveries.push(Delivery { sequence: sequence - 1, loop_delay_s });
        request
    };
    steps.step(&robot, &at(2, 0.0)).await.unwrap();
    let newest = steps.step(&robot, &at(5, 0.006)).await.unwrap();
    let before = server.client.get_robot(&robot).await.unwrap();
    // Fused with the one before.
    let x_m = before.pose.map(|pose| pose.x_m).unwrap();
    assert!(x_m > 0.002 && x_m <= 0.006, "{x_m}");
    for (sequence, samples) in [(4, 3), (3, 4)] {
        let late = steps.step(&robot, &at(sequence, 0.002)).await.unwrap();
        assert_eq!(late.horizon.answers, sequence);
        assert_eq!(late.horizon.sequence, newest.horizon.sequence, "the newest, and no newer");
        assert_eq!(late.horizon.wheel_speeds, newest.horizon.wheel_speeds);
        let after = server.client.get_robot(&robot).await.unwrap();
        assert_eq!((after.pose, after.task), (before.pose, before.task));
        let link = server.client.environment(&robot).await.unwrap().link;
        assert_eq!(link.samples, samples, "its report counts");
    }
    let next = steps.step(&robot, &at(6, 0.007)).await.unwrap();
    assert_eq!((next.horizon.answers, next.horizon.sequence), (6, 6));
}

/// Guards against: after a restart of the robot's computer its clock begins at 0 and every pose is "old".
#[tokio::test]
async fn a_robot_whose_clock_restarts_goes_on_in_a_new_epoch() {
    let server = Server::start();
    let robot = describe(&server.client, "rover-7").await;
    server.client.set_task(&robot, &straight_to(0.3)).await.unwrap();
    let steps = server.client.step_connection();
    for sequence in 1..=20 {
        let sent = 5000.0 + sequence as f64 * 0.03;
        steps.step(&robot, &request(1, sequence, sent)).await.unwrap();
    }
    let before = server.client.get_robot(&robot).await.unwrap();
    // Within the epoch that is an error, and says what to do.
    let error = steps.step(&robot, &request(1, 21, 0.03)).await.unwrap_err();
    assert_eq!(error.status(), Some(Status::FailedPrecondition), "{error}");
    assert!(error.to_string().contains("new epoch"), "{error}");
    let after = server.client.get_robot(&robot).await.unwrap();
    assert_eq!((after.pose, after.epoch), (before.pose, Some(1)));
    let mut moves = false;
    for sequence in 1..=10 {
        let sent = sequence as f64 * 0.03;
        let reply = steps.step(&robot, &request(2, sequence, sent)).await.unwrap();
        let horizon = reply.horizon;
        assert_eq!((horizon.answers, horizon.sequence), (sequence, sequence));
        assert!(horizon.start_s >= sent - 0.5 && horizon.start_s < sent + 1.0, "{horizon:?}");
        moves |= horizon.wheel_speeds.iter().any(|speeds| speeds.left_rad_per_s > 0.0);
    }
    assert!(moves, "the task goes on");
    let after = server.client.get_robot(&robot).await.unwrap();
    assert_eq!(after.epoch, Some(2));
    assert!(after.pose.is_some_and(|pose| pose.taken_s < 1.0), "{after:?}");
}

/// Guards against: two agents drive one robot in turns.
#[tokio::test]
async fn a_second_agent_takes_over_and_the_first_is_told() {
    let server = Server::start();
    let robot = describe(&server.client, "rover-7").await;
    let (first, second) = (server.client.step_connection(), server.client.step_connection());
    first.step(&robot, &request(1, 1, 10.0)).await.unwrap();
    second.step(&robot, &request(2, 1, 3.0)).await.unwrap();
    for sequence in 2..5 {
        let sent = 10.0 + sequence as f64 * 0.03;
        let error = first.step(&robot, &request(1, sequence, sent)).await.unwrap_err();
        assert_eq!(error.status(), Some(Status::Aborted), "{error}");
        let problem = error.problem().unwrap();
        assert_eq!(problem.details[0].reason, "EPOCH_SUPERSEDED");
        let sent = 3.0 + sequence as f64 * 0.03;
        second.step(&robot, &request(2, sequence, sent)).await.unwrap();
    }
    assert_eq!(server.client.get_robot(&robot).await.unwrap().epoch, Some(2));
}
