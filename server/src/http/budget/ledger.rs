//! Who holds how much.

use super::Peer;
use std::collections::{BTreeMap, HashMap};

/// How much may be held at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Limits {
    /// By all peers together.
    pub(crate) overall: usize,
    /// By one of them.
    pub(crate) per_peer: usize,
}

/// Which limit is in the way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scope {
    /// That of the peer.
    Peer,
    /// That of all together.
    Overall,
}

/// What is held, by peer, and by whom of the peer's that can be ended in favour of others.
#[derive(Debug)]
pub(super) struct Ledger<H> {
    limits: Limits,
    held: usize,
    last: u64,
    peers: HashMap<Peer, Account<H>>,
}

/// What one peer holds.
#[derive(Debug)]
pub(super) struct Account<H> {
    held: usize,
    /// In the order in which they began.
    pub(super) holders: BTreeMap<u64, Holding<H>>,
}

/// What one holder holds.
#[derive(Debug)]
pub(super) struct Holding<H> {
    units: usize,
    pub(super) holder: H,
}

impl<H> Ledger<H> {
    pub(super) fn new(limits: Limits) -> Self {
        Self { limits, held: 0, last: 0, peers: HashMap::new() }
    }

    pub(super) fn limits(&self) -> Limits {
        self.limits
    }

    /// The limit that `peer` would exceed with so many more units.
    pub(super) fn exceeded(&self, peer: Peer, more: usize) -> Option<Scope> {
        if self.held_by(peer).saturating_add(more) > self.limits.per_peer {
            Some(Scope::Peer)
        } else if self.held.saturating_add(more) > self.limits.overall {
            Some(Scope::Overall)
        } else {
            None
        }
    }

    /// A new holder of so many units, whether or not that exceeds a limit.
    pub(super) fn join(&mut self, peer: Peer, units: usize, holder: H) -> u64 {
        self.last += 1;
        let id = self.last;
        let account = self.account(peer);
        account.held += units;
        account.holders.insert(id, Holding { units, holder });
        self.held += units;
        id
    }

    /// More units for a holder, whether or not that exceeds a limit; false where it has been ended.
    pub(super) fn grow(&mut self, peer: Peer, id: u64, more: usize) -> bool {
        let Some(account) = self.peers.get_mut(&peer) else { return false };
        let Some(holding) = account.holders.get_mut(&id) else { return false };
        holding.units += more;
        account.held += more;
        self.held += more;
        true
    }

    /// Takes a holder out, with what it held. None where it has been taken out before.
    pub(super) fn leave(&mut self, peer: Peer, id: u64) -> Option<H> {
        let Holding { units, holder } = self.peers.get_mut(&peer)?.holders.remove(&id)?;
        self.give(peer, units);
        Some(holder)
    }

    /// From now on no one can end this holder; what it holds is given back by [`Ledger::give`]. None where it has been
    /// ended before.
    pub(super) fn settle(&mut self, peer: Peer, id: u64) -> Option<usize> {
        let holding = self.peers.get_mut(&peer)?.holders.remove(&id)?;
        Some(holding.units)
    }

    /// Gives units back that no holder has.
    pub(super) fn give(&mut self, peer: Peer, units: usize) {
        self.held -= units;
        if let Some(account) = self.peers.get_mut(&peer) {
            account.held -= units;
            if account.held == 0 && account.holders.is_empty() {
                self.peers.remove(&peer);
            }
        }
    }

    /// Takes out, in favour of `peer`, the holder that `choose` picks of an account: of the peer's own where its own
    /// limit is in the way, else of the account that holds most and has one to pick; never of a peer that holds no more
    /// than `peer` itself.
    pub(super) fn evict(
        &mut self,
        peer: Peer,
        scope: Scope,
        choose: impl Fn(&Account<H>) -> Option<u64>,
    ) -> Option<H> {
        let (owner, id) = match scope {
            Scope::Peer => (peer, choose(self.peers.get(&peer)?)?),
            Scope::Overall => {
                let own = self.held_by(peer);
                let is_greedier =
                    |(owner, account): &(&Peer, &Account<H>)| **owner == peer || account.held > own;
                let mut accounts: Vec<_> = self.peers.iter().filter(is_greedier).collect();
                accounts.sort_unstable_by_key(|(_, account)| std::cmp::Reverse(account.held));
                let mut picked = accounts.into_iter();
                picked.find_map(|(owner, account)| Some((*owner, choose(account)?)))?
            }
        };
        self.leave(owner, id)
    }

    /// What a peer holds.
    pub(super) fn held_by(&self, peer: Peer) -> usize {
        self.peers.get(&peer).map_or(0, |account| account.held)
    }

    /// What all hold.
    #[cfg(test)]
    pub(super) fn held(&self) -> usize {
        self.held
    }

    /// How many peers hold something.
    #[cfg(test)]
    pub(super) fn peers(&self) -> usize {
        self.peers.len()
    }

    fn account(&mut self, peer: Peer) -> &mut Account<H> {
        let new = || Account { held: 0, holders: BTreeMap::new() };
        self.peers.entry(peer).or_insert_with(new)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn peer(number: u8) -> Peer {
        Peer::of([192, 0, 2, number].into())
    }

    fn oldest(account: &Account<u8>) -> Option<u64> {
        account.holders.keys().next().copied()
    }

    /// Guards against: someone with little is ended for someone with much.
    #[test]
    fn who_holds_most_gives_way_and_no_one_to_one_who_holds_as_much() {
        let mut ledger = Ledger::new(Limits { overall: 6, per_peer: 4 });
        for _ in 0..4 {
            ledger.join(peer(1), 1, 1);
        }
        for _ in 0..2 {
            ledger.join(peer(2), 1, 2);
        }
        assert_eq!(ledger.exceeded(peer(1), 1), Some(Scope::Peer));
        assert_eq!(ledger.exceeded(peer(2), 1), Some(Scope::Overall));
        assert_eq!(ledger.evict(peer(2), Scope::Overall, oldest), Some(1));
        ledger.join(peer(2), 1, 2);
        assert_eq!((ledger.held_by(peer(1)), ledger.held_by(peer(2))), (3, 3));
        // The other one holds no more than it does itself: only its own may go.
        assert_eq!(ledger.evict(peer(2), Scope::Overall, oldest), Some(2));
        // Who cannot be picked is passed over.
        let none_of_one = |account: &Account<u8>| {
            account.holders.iter().find(|(_, held)| held.holder != 1).map(|(id, _)| *id)
        };
        assert_eq!(ledger.evict(peer(3), Scope::Overall, none_of_one), Some(2));
    }

    proptest! {
        /// Whatever is done in whatever order: the sums are those of what is held, and nothing is left at the end.
        #[test]
        fn all_that_is_given_comes_back(
            calls in prop::collection::vec((0_u8..5, 0_u8..4, 0_usize..9, any::<prop::sample::Index>()), 1..200)
        ) {
            let mut ledger = Ledger::new(Limits { overall: 100, per_peer: 50 });
            let mut holding: Vec<(u8, u64, usize)> = Vec::new();
            let mut settled: Vec<(u8, usize)> = Vec::new();
            for (call, owner, units, index) in calls {
                let at = if holding.is_empty() { None } else { Some(index.index(holding.len())) };
                match (call, at) {
                    (0, _) => holding.push((owner, ledger.join(peer(owner), units, owner), units)),
                    (1, Some(at)) => {
                        let (owner, id, held) = &mut holding[at];
                        prop_assert!(ledger.grow(peer(*owner), *id, units));
                        *held += units;
                    }
                    (2, Some(at)) => {
                        let (owner, id, _) = holding.swap_remove(at);
                        prop_assert_eq!(ledger.leave(peer(owner), id), Some(owner));
                        prop_assert_eq!(ledger.leave(peer(owner), id), None, "once");
                    }
                    (3, Some(at)) => {
                        let (owner, id, held) = holding.swap_remove(at);
                        prop_assert_eq!(ledger.settle(peer(owner), id), Some(held));
                        settled.push((owner, held));
                    }
                    (4, _) => if let Some(ended) = ledger.evict(peer(owner), Scope::Overall, oldest) {
                        let first = holding.iter().enumerate().filter(|(_, held)| held.0 == ended);
                        let first = first.min_by_key(|(_, held)| held.1).unwrap().0;
                        holding.remove(first);
                    },
                    _ => {}
                }
                let held = |of: u8| {
                    let holding: usize = holding.iter().filter(|it| it.0 == of).map(|it| it.2).sum();
                    let settled: usize = settled.iter().filter(|it| it.0 == of).map(|it| it.1).sum();
                    holding + settled
                };
                for owner in 0..4 {
                    prop_assert_eq!(ledger.held_by(peer(owner)), held(owner));
                }
                prop_assert_eq!(ledger.held(), (0..4).map(held).sum::<usize>());
            }
            for (owner, id, _) in holding {
                ledger.leave(peer(owner), id);
            }
            for (owner, units) in settled {
                ledger.give(peer(owner), units);
            }
            prop_assert_eq!((ledger.held(), ledger.peers()), (0, 0));
        }
    }
}
