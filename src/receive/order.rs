//! Packet counts: what was lost, doubled or overtaken in a stream.
//!
//! A count has four bits, so nine lost packets look like seven that were overtaken; the time stamp
//! distinguishes them.

/// The packets of one type in one stream.
#[derive(Clone, Debug)]
pub(super) struct Stream {
    /// Count of the next packet.
    next: u8,
    /// Latest time.
    latest: Option<i128>,
    /// Times of the last packet of each count.
    seen: [Option<i128>; 16],
    /// Packets that are missing.
    missing: u64,
}

/// Order of a packet by its count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Order {
    /// In order; some before it may be missing.
    Next,
    /// Overtaken by later ones.
    Overtaken,
    /// Seen before.
    Double,
}

impl Stream {
    /// A stream that begins with this packet.
    pub(super) fn begin(count: u8, time_ps: Option<i128>) -> Self {
        let mut seen = [None; 16];
        seen[usize::from(count & 15)] = time_ps;
        Self { next: (count + 1) & 15, latest: time_ps, seen, missing: 0 }
    }

    /// Packets that are missing: at least, for sixteen in a row are not seen.
    pub(super) fn missing(&self) -> u64 {
        self.missing
    }

    /// Whether a packet is one of the last sixteen again.
    pub(super) fn is_double(&self, count: u8, time_ps: Option<i128>) -> bool {
        time_ps.is_some() && self.seen[usize::from(count & 15)] == time_ps
    }

    /// The stream goes on with this packet: what was noted as its latest was none of it. What is missing
    /// stays counted.
    pub(super) fn begin_again(&mut self, count: u8, time_ps: Option<i128>) {
        let missing = self.missing;
        *self = Self { missing, ..Self::begin(count, time_ps) };
    }

    /// Whether the latest packet lies more than so much after a time.
    pub(super) fn is_ahead(&self, time_ps: Option<i128>, by_ps: i128) -> bool {
        self.latest.zip(time_ps).is_some_and(|(latest, time)| latest.saturating_sub(time) > by_ps)
    }

    /// Judges the next packet.
    pub(super) fn judge(&mut self, count: u8, time_ps: Option<i128>) -> Order {
        if self.is_double(count, time_ps) {
            return Order::Double;
        }
        self.seen[usize::from(count & 15)] = time_ps;
        if time_ps < self.latest {
            // It had been counted as missing, unless the stream began after it.
            self.missing = self.missing.saturating_sub(1);
            return Order::Overtaken;
        }
        self.latest = time_ps;
        self.missing = self.missing.saturating_add(u64::from(count.wrapping_sub(self.next) & 15));
        self.next = (count + 1) & 15;
        Order::Next
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One forged packet that lies ahead makes no later ones overtaken for good.
    #[test]
    fn a_stream_goes_on_after_a_packet_that_was_none_of_it() {
        let mut stream = Stream::begin(0, Some(0));
        assert_eq!(stream.judge(3, Some(3)), Order::Next);
        assert_eq!((stream.judge(4, Some(900)), stream.missing()), (Order::Next, 2));
        assert!(stream.is_ahead(Some(4), 100) && !stream.is_ahead(Some(850), 100));
        stream.begin_again(4, Some(4));
        assert_eq!((stream.judge(6, Some(6)), stream.missing()), (Order::Next, 3));
    }

    #[test]
    fn counts_distinguish_losses_doubles_and_overtaking() {
        let mut stream = Stream::begin(14, Some(0));
        let mut judge = |count, time| (stream.judge(count, Some(time)), stream.missing());
        assert_eq!(judge(15, 1), (Order::Next, 0));
        assert_eq!(judge(0, 2), (Order::Next, 0));
        assert_eq!(judge(0, 2), (Order::Double, 0));
        assert_eq!(judge(3, 5), (Order::Next, 2));
        assert_eq!(judge(2, 4), (Order::Overtaken, 1));
        assert_eq!(judge(2, 4), (Order::Double, 1));
        assert_eq!(judge(4, 6), (Order::Next, 1));
        // Eleven lost: a count of 0 after 4.
        assert_eq!(judge(0, 18), (Order::Next, 12));
    }
}
