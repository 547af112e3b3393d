//! Replies that no sane server sends.

use super::*;

/// A server that answers one request with `answer` and then says nothing more.
fn once(answer: impl Fn(&step::Request) -> Horizon + Send + Sync + 'static) -> Connect {
    let answered = Arc::new(Mutex::new(false));
    let connect = answering(answer);
    Box::new(move || {
        let (answered, step) = (Arc::clone(&answered), connect());
        Box::new(move |request| {
            let is_first = !std::mem::replace(&mut *answered.lock().unwrap(), true);
            if is_first { step(request) } else { Box::pin(std::future::pending()) }
        })
    })
}

/// What a robot that sees no poses is told to do in `duration` s.
async fn blind(connect: Connect, duration: f64) -> Vec<(f64, WheelSpeeds)> {
    let (pipe, mut ends) = pipe();
    let config = Config { duration: Some(duration), ..config() };
    let run = run(config, connect, pipe, Clock::start(), std::future::pending());
    let reading = async {
        let mut lines = Vec::new();
        while let Some(line) = ends.speeds.next().await {
            lines.push(parse(&line));
        }
        ends.done.send(()).unwrap();
        lines
    };
    let (report, lines) = tokio::join!(run, reading);
    assert_eq!(report.unwrap().ended, Ended::Duration);
    lines
}

/// A real robot never holds a speed for ever, nor goes by one reply for long, whatever the server says.
#[tokio::test(start_paused = true)]
async fn one_reply_drives_no_robot_for_long() {
    let ramp = 0.1 / Wheels::default().max_linear_acceleration;
    for (slot, watchdog, at_rest) in [
        (SLOT, 0.0, 0.51 + 0.3),
        (SLOT, 5.0, 0.51 + 1.0),
        (1.0, 5.0, 2.0 + 1.0),
        (0.4, 0.3, 2.0 + 0.3),
    ] {
        let connect = once(move |request| Horizon { slot, watchdog, ..ordinary(request) });
        let lines = blind(connect, 12.0).await;
        let moved = lines.iter().filter(|(_, speeds)| *speeds != WheelSpeeds::ZERO);
        let last = moved.map(|(now, _)| *now).fold(0.0, f64::max);
        let latest = at_rest + ramp + 2.0 * SLOT;
        assert!(
            (at_rest - SLOT..=latest).contains(&last),
            "{last} s by slots of {slot} s, {watchdog} s"
        );
    }
}

/// Neither a horizon of a far future nor one that no one asked for moves the robot, now or later.
#[tokio::test(start_paused = true)]
async fn a_horizon_that_cannot_be_meant_moves_nothing() {
    let far = |request: &step::Request| Horizon {
        start: RobotTime::new(request.sent_s + 5.0),
        ..ordinary(request)
    };
    let foreign = |request: &step::Request| Horizon { sequence: 1 << 53, ..ordinary(request) };
    for lines in [blind(answering(far), 12.0).await, blind(once(foreign), 12.0).await] {
        assert!(lines.len() > 300 && lines.iter().all(|(_, speeds)| *speeds == WheelSpeeds::ZERO));
    }
}
