//! How far the numbers of a link model may go.

/// Longest delay or silence in s that a model may ask for; five times the worst ever recorded.
pub const LONGEST_DELAY: f64 = 60.0;

/// Most outages in a model: they are looked up per packet and checked per request.
pub const MAX_OUTAGES: usize = 1000;

/// Closest to 1 that the slot-to-slot correlation of lateness may come, in magnitude: bursts of 100 slots.
/// What lasts longer is an outage.
pub const MAX_LATE_CORRELATION: f64 = 0.99;

/// Greatest expected number of silences at once. Overlapping ones join: at 3 the link is open for 5 % of the time
/// (e^-3), and much beyond it practically never again.
pub const MAX_SILENCE_LOAD: f64 = 3.0;
