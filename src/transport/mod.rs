//! Real time: rings, pacer, health. Knows no physics.

/// How pulses are released.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Real time, or as fast as they are made.
    pub pace: Pace,
    /// What happens when generation cannot keep up in real time.
    pub policy: Policy,
    /// Release of a pulse minus its emission time, s: how far ahead pulses are made.
    pub latency_s: f64,
    /// Slots of the ring between generation and release.
    pub ring_slots: usize,
    /// Threads that make pulses; 0: as many as the machine has.
    pub threads: usize,
}

/// When pulses are released.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// At `t0 + n/PRF`.
    Realtime,
    /// As soon as they are made; nothing is late and nothing is dropped.
    Fast,
}

/// What happens when generation cannot keep up in real time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Policy {
    /// End with an error that names the stage that is short.
    Stop,
    /// Lossless: time stretches, late pulses are flagged and counted.
    Slip,
    /// Keep real time: missing pulse indices are counted.
    Drop,
}
