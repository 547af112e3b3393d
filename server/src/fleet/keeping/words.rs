//! What was said of stopping: what an earlier run of the server has left, and what the store has still to take in.

use crate::fleet::robot::Arrival;
use crate::store::{Record, StopKeeper, Word, Words};
use std::collections::BTreeMap;
use umwelt_api::RobotId;

/// Where words on stopping are kept, and what an earlier run of the server has left there.
#[derive(Debug, Default)]
pub(crate) struct Stops {
    /// None where there is only the store.
    pub(crate) journal: Option<StopKeeper>,
    pub(crate) words: Words,
}

impl Stops {
    /// What a stored `record` of robot `id` is with the words that were kept beside it.
    pub(crate) fn merge(&self, id: &RobotId, record: &mut Record) {
        if let Some((_, word)) = self.words.last.get(id) {
            record.stopped = *word == Word::Stop;
        }
        // Someone was stopped, and no one knows who.
        record.stopped |= self.words.is_damaged;
    }
}

/// What the store has still to take in.
#[derive(Debug, Default)]
pub(crate) struct Unkept {
    /// The last word about each robot that may be kept elsewhere than in the store.
    pub(super) due: BTreeMap<RobotId, u64>,
    /// Up to which arrival the store holds the words about a robot.
    pub(super) held: BTreeMap<RobotId, u64>,
}

impl Unkept {
    /// What an earlier run has left to do, for the robots that there are. Words about a robot that `is_unreadable` stay in
    /// the journal, for the program that can read it.
    pub(crate) fn of(
        words: &Words,
        robots: impl Iterator<Item = RobotId>,
        is_unreadable: impl Fn(&RobotId) -> bool,
    ) -> Self {
        let mut unkept = Self::default();
        for (id, (arrival, _)) in words.last.iter().filter(|(id, _)| !is_unreadable(id)) {
            unkept.due.insert(id.clone(), *arrival);
        }
        if words.is_damaged {
            for id in robots {
                unkept.due.entry(id).or_insert(1);
            }
        }
        unkept
    }

    /// Whether nothing was due about this robot before.
    pub(super) fn mark(&mut self, id: &RobotId, arrival: Arrival) -> bool {
        let before = self.due.get(id).copied();
        self.due.insert(id.clone(), arrival.0.max(before.unwrap_or(0)));
        before.is_none()
    }

    pub(super) fn hold(&mut self, id: &RobotId, arrival: u64) {
        let held = self.held.entry(id.clone()).or_default();
        *held = arrival.max(*held);
    }

    fn is_held(&self, id: &RobotId, due: u64) -> bool {
        self.held.get(id).is_some_and(|held| *held >= due)
    }

    /// Robots about which the store does not hold the last word.
    pub(super) fn missing(&self) -> Vec<RobotId> {
        let due = self.due.iter().filter(|(id, due)| !self.is_held(id, **due));
        due.map(|(id, _)| id.clone()).collect()
    }

    /// Nothing but the store holds a word up to those in `held`.
    pub(super) fn settle(&mut self, held: &BTreeMap<RobotId, u64>) {
        self.due.retain(|id, due| held.get(id).is_none_or(|held| held < due));
        self.held.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Guards against a stop that is forgotten because the program that was started in between could not read its robot.
    #[test]
    fn words_about_a_robot_that_cannot_be_read_are_left_in_the_journal() {
        let [one, other]: [RobotId; 2] = ["a", "b"].map(|id| id.parse().unwrap());
        let last = [(one.clone(), (5, Word::Stop)), (other.clone(), (6, Word::Stop))].into();
        let words = Words { last, ..Words::default() };
        let due = |is_unreadable: &dyn Fn(&RobotId) -> bool| {
            Unkept::of(&words, std::iter::empty(), is_unreadable).missing()
        };
        assert_eq!(due(&|_| false), [one.clone(), other.clone()]);
        assert_eq!(due(&|id| *id == one), [other]);
    }
}
