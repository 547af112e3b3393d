//! The session of a robot with its agent: which request is new, repeated, late, or of an agent that was superseded.
//!
//! Pure: no clock, no channel. A verdict changes nothing; [`Session::answered`] does.

use super::refusal::Refusal;
use std::collections::VecDeque;
use std::sync::Arc;
use umwelt_api::step::Reply;
use umwelt_core::exchange::Request;
use umwelt_core::time::RobotTime;

/// Superseded epochs remembered: more restarts than an agent makes while a packet of its first run is on its way.
pub(crate) const SUPERSEDED: usize = 16;

/// Replies kept for repeats: more than an agent has in flight on one connection.
pub(crate) const REPLIES: usize = 8;

/// A robot clock that jumps back by more than this many s within an epoch has restarted. Less is an agent that
/// stamped its requests out of order.
const JUMP: f64 = 1.0;

/// What a request is.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Verdict {
    /// The first of the first agent.
    First,
    /// The first of an agent that takes the robot over.
    Takeover,
    /// The newest of its epoch.
    Newest,
    /// One that was answered before.
    Repeat(Arc<Reply>),
    /// One that was overtaken by a newer one.
    Late,
}

/// The epoch that holds.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Current {
    epoch: u64,
    /// The highest sequence answered.
    sequence: u64,
    /// When the latest of its requests was sent.
    sent: RobotTime,
}

/// What is remembered of the exchange.
#[derive(Clone, Debug, Default)]
pub(crate) struct Session {
    current: Option<Current>,
    /// Epochs that were superseded, oldest first.
    superseded: VecDeque<u64>,
    /// The last replies of the current epoch with the sequences that they answer, oldest first.
    replies: VecDeque<(u64, Arc<Reply>)>,
}

impl Session {
    /// What `request` of `epoch` is.
    pub(crate) fn judge(&self, epoch: u64, request: &Request) -> Result<Verdict, Refusal> {
        let Some(current) = self.current else { return Ok(Verdict::First) };
        if epoch != current.epoch {
            if self.superseded.contains(&epoch) {
                return Err(Refusal::Superseded { epoch });
            }
            return Ok(Verdict::Takeover);
        }
        let kept = self.replies.iter().find(|(sequence, _)| *sequence == request.sequence);
        if let Some((_, reply)) = kept {
            return Ok(Verdict::Repeat(Arc::clone(reply)));
        }
        if request.sequence <= current.sequence {
            return Ok(Verdict::Late);
        }
        if request.sent < current.sent - JUMP {
            let (sent, newest) = (request.sent.seconds(), current.sent.seconds());
            return Err(Refusal::ClockWentBack { sent, newest });
        }
        Ok(Verdict::Newest)
    }

    /// `request` of `epoch` was answered with `reply`, as a first, newest, late one or a takeover.
    pub(crate) fn answered(&mut self, epoch: u64, request: &Request, reply: Arc<Reply>) {
        match &mut self.current {
            Some(current) if current.epoch == epoch => {
                current.sequence = current.sequence.max(request.sequence);
                current.sent = current.sent.later(request.sent);
            }
            current => {
                if let Some(old) = current {
                    if self.superseded.len() == SUPERSEDED {
                        self.superseded.pop_front();
                    }
                    self.superseded.push_back(old.epoch);
                }
                let (sequence, sent) = (request.sequence, request.sent);
                *current = Some(Current { epoch, sequence, sent });
                self.replies.clear();
            }
        }
        if self.replies.len() == REPLIES {
            self.replies.pop_front();
        }
        self.replies.push_back((request.sequence, reply));
    }

    /// The epoch that holds.
    pub(crate) fn epoch(&self) -> Option<u64> {
        self.current.map(|current| current.epoch)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use umwelt_api::step::Horizon;
    use umwelt_api::task::Stage;

    fn request(sequence: u64, sent: f64) -> Request {
        Request {
            sequence,
            connection: 0,
            sent: RobotTime::new(sent),
            observations: Default::default(),
            deliveries: Default::default(),
            playing: None,
            limits: Default::default(),
        }
    }

    /// A reply that can be told from every other by its `number`.
    fn reply(number: u64) -> Arc<Reply> {
        let horizon = Horizon {
            sequence: number,
            answers: number,
            start_s: 0.0,
            slot_s: 0.03,
            watchdog_s: 0.3,
            valid_until_s: None,
            wheel_speeds: Vec::new(),
        };
        Arc::new(Reply { horizon, stopped: false, stage: Stage::Idle, drive: None })
    }

    /// Judges and answers as the robot does.
    fn send(
        session: &mut Session,
        epoch: u64,
        request: &Request,
        number: u64,
    ) -> Result<Verdict, Refusal> {
        let verdict = session.judge(epoch, request)?;
        if !matches!(verdict, Verdict::Repeat(_)) {
            session.answered(epoch, request, reply(number));
        }
        Ok(verdict)
    }

    #[test]
    fn a_clock_that_runs_backwards_is_refused_and_does_no_harm() {
        let mut session = Session::default();
        send(&mut session, 1, &request(1, 100.0), 1).unwrap();
        let back = request(2, 98.9);
        assert_eq!(
            session.judge(1, &back),
            Err(Refusal::ClockWentBack { sent: 98.9, newest: 100.0 })
        );
        assert_eq!(session.judge(1, &request(2, 99.1)), Ok(Verdict::Newest), "jitter is none");
        assert_eq!(session.judge(2, &back), Ok(Verdict::Takeover), "a new epoch may");
    }

    /// Guards against: a clock that creeps backwards, each time by less than the jump, and is never noticed.
    #[test]
    fn a_clock_cannot_creep_backwards() {
        let mut session = Session::default();
        send(&mut session, 1, &request(1, 100.0), 1).unwrap();
        send(&mut session, 1, &request(2, 99.1), 2).unwrap();
        assert!(session.judge(1, &request(3, 98.2)).is_err());
    }

    #[test]
    fn the_seventeenth_takeover_forgets_the_first_epoch() {
        let mut session = Session::default();
        for epoch in 0..=SUPERSEDED as u64 {
            send(&mut session, epoch, &request(1, 0.0), epoch).unwrap();
        }
        assert_eq!(session.judge(0, &request(2, 1.0)), Err(Refusal::Superseded { epoch: 0 }));
        send(&mut session, 99, &request(1, 0.0), 99).unwrap();
        assert_eq!(session.judge(0, &request(2, 1.0)), Ok(Verdict::Takeover));
        assert_eq!(session.judge(1, &request(2, 1.0)), Err(Refusal::Superseded { epoch: 1 }));
    }

    proptest! {
        /// Against a model that remembers everything: the whole history of answers, in order.
        #[test]
        fn verdicts_follow_from_the_history(
            calls in prop::collection::vec((0u64..4, 0u64..24), 1..200)
        ) {
            let mut session = Session::default();
            // (epoch, sequence, number of the reply) of every answer.
            let mut history: Vec<(u64, u64, u64)> = Vec::new();
            for (number, (epoch, sequence)) in calls.into_iter().enumerate() {
                let number = number as u64;
                let request = request(sequence, sequence as f64 * 0.03);
                let verdict = send(&mut session, epoch, &request, number);

                let holds = history.last().map(|last| last.0);
                let of_epoch: Vec<_> = history.iter().filter(|answer| answer.0 == epoch).collect();
                let expected = if holds.is_none() {
                    Ok(Verdict::First)
                } else if holds != Some(epoch) {
                    // At most four epochs here: none is forgotten.
                    if of_epoch.is_empty() { Ok(Verdict::Takeover) } else { Err(Refusal::Superseded { epoch }) }
                } else if let Some(kept) = of_epoch.iter().rev().take(REPLIES).find(|answer| answer.1 == sequence) {
                    Ok(Verdict::Repeat(reply(kept.2)))
                } else if of_epoch.iter().any(|answer| answer.1 >= sequence) {
                    Ok(Verdict::Late)
                } else {
                    Ok(Verdict::Newest)
                };
                if expected.as_ref().is_ok_and(|verdict| !matches!(verdict, Verdict::Repeat(_))) {
                    history.push((epoch, sequence, number));
                }
                prop_assert_eq!(verdict, expected);
                prop_assert!(session.replies.len() <= REPLIES && session.superseded.len() <= SUPERSEDED);
            }
        }
    }
}
