//! Clocks of transmitters and receivers, as they are described. What they do is the business of
//! `radar::clock`.

/// A clock. Its reading less the time of the run is `x`, s; `y = dx/dt`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Clock {
    /// Reading less time at pulse 0, s.
    pub offset_s: f64,
    /// Fractional frequency at pulse 0.
    pub drift: f64,
    /// Growth of the fractional frequency, 1/s.
    pub ageing_per_s: f64,
    /// One-sided spectrum of the fractional frequency, `S_y(f) = sum of h_a f^a`, `a` from -2 to 2.
    pub noise: [f64; 5],
    /// Highest frequency of phase noise (`a` of 1 and 2), Hz; `None`: half the pulse rate.
    pub bandwidth_hz: Option<f64>,
}

/// A clock of a certain name.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedClock {
    /// Name of the antenna that it belongs to.
    pub name: String,
    /// The clock.
    pub clock: Clock,
}

/// All clocks of a radar; antennas may share one. Those without are right.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Clocks {
    /// The clocks.
    pub clocks: Vec<NamedClock>,
    /// Clock of each transmitter, by its place; shorter lists leave the rest without.
    pub transmitters: Vec<Option<usize>>,
    /// Clock of each receiver.
    pub receivers: Vec<Option<usize>>,
}
