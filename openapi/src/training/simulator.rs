//! What only the simulator can say about the numbers of a link, in its words. A program without it leaves that to the
//! server, which has it.

/// Whether late slots of this probability, and of this one after a late one, form a chain.
#[cfg(feature = "core")]
pub(super) fn bursts(probability: f64, after_late: f64) -> Result<(), String> {
    use umwelt_core::link::{LatePackets, LinkError, LinkModel, Rtt};
    let late = LatePackets { probability, after_late, ..LatePackets::NONE };
    match (LinkModel { late, ..LinkModel::ordinary(Rtt::Constant(0.0)) }).validate() {
        Err(error @ LinkError::Burst { .. }) => Err(error.to_string()),
        _ => Ok(()),
    }
}

/// Whether silences of so many per second and of these durations in s leave a link.
#[cfg(feature = "core")]
pub(super) fn silences(rate: f64, shortest: f64, longest: f64) -> Result<(), String> {
    use umwelt_core::link::{LinkError, LinkModel, Rtt, Silences};
    let silences = Silences { rate, shortest, longest };
    match (LinkModel { silences, ..LinkModel::ordinary(Rtt::Constant(0.0)) }).validate() {
        Err(error @ LinkError::SilenceLoad { .. }) => Err(error.to_string()),
        _ => Ok(()),
    }
}

#[cfg(not(feature = "core"))]
pub(super) fn bursts(_: f64, _: f64) -> Result<(), String> {
    Ok(())
}

#[cfg(not(feature = "core"))]
pub(super) fn silences(_: f64, _: f64, _: f64) -> Result<(), String> {
    Ok(())
}
