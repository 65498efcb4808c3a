//! Packet counts: what was lost, doubled or overtaken in a stream.

/// The packets of one type in one stream.
#[derive(Clone, Debug)]
pub(super) struct Stream {
    next: u8,
    /// Times of the last packet of each count.
    seen: [Option<i128>; 16],
}

/// What a packet's count says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Order {
    /// As expected.
    Next,
    /// After so many that are missing (at least: the count has four bits).
    After(u8),
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
        Self { next: (count + 1) & 15, seen }
    }

    /// Judges the next packet.
    pub(super) fn judge(&mut self, count: u8, time_ps: Option<i128>) -> Order {
        let seen = &mut self.seen[usize::from(count & 15)];
        if time_ps.is_some() && *seen == time_ps {
            return Order::Double;
        }
        *seen = time_ps;
        let ahead = count.wrapping_sub(self.next) & 15;
        if ahead >= 8 {
            return Order::Overtaken;
        }
        self.next = (count + 1) & 15;
        if ahead == 0 { Order::Next } else { Order::After(ahead) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_tell_losses_doubles_and_overtaking() {
        let mut stream = Stream::begin(14, Some(0));
        assert_eq!(stream.judge(15, Some(1)), Order::Next);
        assert_eq!(stream.judge(0, Some(2)), Order::Next);
        assert_eq!(stream.judge(0, Some(2)), Order::Double);
        assert_eq!(stream.judge(3, Some(5)), Order::After(2));
        assert_eq!(stream.judge(2, Some(4)), Order::Overtaken);
        assert_eq!(stream.judge(2, Some(4)), Order::Double);
        assert_eq!(stream.judge(4, Some(6)), Order::Next);
    }
}
