//! What results say in plain words. The words of a verdict are made here alone; the contract has them whole, and finding by
//! finding for programs.

mod champion;
mod claim;

pub(super) use champion::{champion, entry};
pub(crate) use claim::judged;
