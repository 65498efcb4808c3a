//! One browser: what it has not seen yet, and what it asks.
//!
//! Nothing is queued for a browser. At every tick it gets what is new since its last one from the hub's
//! buffers; what has gone from them meanwhile is left out, and counted. One that takes nothing for some
//! seconds is left.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use axum::extract::ws::{CloseFrame, Message, WebSocket, close_code};
use serde::Deserialize;
use serde_json::json;
use tokio::sync::{OwnedSemaphorePermit, mpsc};
use tokio::time::{MissedTickBehavior, interval, timeout};

use super::hub::{Hub, State};
use super::meter::Meter;
use super::status;
use crate::pipeline::control_lines::LONGEST_LINE;

/// Time from an update to the next.
const TICK: Duration = Duration::from_millis(100);
/// Ticks from one status to the next.
const STATUS_TICKS: u64 = 5;
/// Ticks from one plan to the next.
const PLAN_TICKS: u64 = 2;
/// Most range lines in an update.
const ROWS: usize = 64;
/// Most radials in an update: more than come in a tick of the fastest antenna that there is time for.
const RADIALS: usize = 512;
/// How long a browser may take nothing.
const UNREAD: Duration = Duration::from_secs(5);
/// Messages of a browser: at once, and in a second.
const MESSAGES: f64 = 40.0;
const MESSAGES_PER_S: f64 = 20.0;

/// What a browser asks.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Asked {
    /// Channel whose range lines are shown.
    channel: Option<usize>,
    /// Whether its range-Doppler map is shown.
    doppler: Option<bool>,
    /// Whether its plan position panel is shown.
    ppi: Option<bool>,
    /// A change of a report, as in docs/control.md.
    change: Option<String>,
}

/// Where a browser is in the hub's buffers.
#[derive(Default)]
struct Place {
    channel: usize,
    row: u64,
    doppler: bool,
    map: u64,
    ppi: bool,
    radial: u64,
    epoch: Option<u32>,
    points: usize,
    pulse: Option<u64>,
    ticks: u64,
}

/// Counts a browser while it is there.
struct Present(Arc<Hub>);

impl Drop for Present {
    fn drop(&mut self) {
        self.0.browsers.fetch_sub(1, Ordering::Relaxed);
    }
}

/// Serves a browser until it goes or the run ends.
pub async fn serve(mut socket: WebSocket, hub: Arc<Hub>, meter: Meter, _permit: OwnedSemaphorePermit) {
    meter.message();
    hub.browsers.fetch_add(1, Ordering::Relaxed);
    let _present = Present(Arc::clone(&hub));
    let mut place = Place::default();
    let mut ticks = interval(TICK);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let (answers, mut answered) = mpsc::channel::<String>(1);
    let mut waiting = false;
    let (mut allowed, mut read) = (MESSAGES, Instant::now());
    if !send(&mut socket, vec![Message::text(hub.about.clone())]).await {
        return;
    }
    loop {
        tokio::select! {
            _ = ticks.tick() => {
                let ended = hub.has_ended();
                let messages = place.update(&hub, ended);
                if !send(&mut socket, messages).await {
                    return;
                }
                if ended {
                    close(&mut socket, close_code::NORMAL, "the run has ended").await;
                    return;
                }
            }
            Some(answer) = answered.recv() => {
                waiting = false;
                if !send(&mut socket, vec![Message::text(answer)]).await {
                    return;
                }
            }
            message = socket.recv() => {
                let Some(Ok(message)) = message else { return };
                allowed = (allowed + read.elapsed().as_secs_f64() * MESSAGES_PER_S).min(MESSAGES) - 1.0;
                read = Instant::now();
                if allowed < 0.0 {
                    close(&mut socket, close_code::POLICY, "more than 20 messages a second").await;
                    return;
                }
                match message {
                    Message::Text(text) => {
                        meter.message();
                        let Ok(asked) = serde_json::from_str::<Asked>(&text) else {
                            close(&mut socket, close_code::POLICY, "not a message of the page").await;
                            return;
                        };
                        if let Some(line) = asked.change {
                            let refusal = if waiting { Some("error a change is still being made: wait for its answer") } else { ask(&hub, line, answers.clone()) };
                            waiting |= refusal.is_none();
                            if let Some(refusal) = refusal && !send(&mut socket, vec![answer(refusal)]).await {
                                return;
                            }
                        }
                        place.subscribe(asked.channel, asked.doppler);
                        place.ppi = asked.ppi.unwrap_or(place.ppi);
                    }
                    Message::Close(_) => return,
                    Message::Ping(_) | Message::Pong(_) => {}
                    Message::Binary(_) => {
                        close(&mut socket, close_code::UNSUPPORTED, "not a message of the page").await;
                        return;
                    }
                }
            }
        }
    }
}

fn answer(text: &str) -> Message {
    Message::text(json!({ "kind": "answer", "text": text }).to_string())
}

/// Asks the run for a change without holding up the server; why not, otherwise.
fn ask(hub: &Arc<Hub>, line: String, answers: mpsc::Sender<String>) -> Option<&'static str> {
    let Some(control) = hub.control.clone() else {
        return Some("error this run takes no changes from its page: start it with --monitor-control");
    };
    if line.len() > LONGEST_LINE {
        return Some("error a change of more than 256 bytes: allowed: at most so many");
    }
    if line.contains(char::is_control) {
        return Some("error a change with control characters: allowed: one line of text");
    }
    tokio::task::spawn_blocking(move || {
        let text = match control.line(&line) {
            Ok((pulse, change)) => format!("ok pulse {pulse} {change}"),
            Err(error) => format!("error {error}"),
        };
        let _ = answers.blocking_send(json!({ "kind": "answer", "text": text }).to_string());
    });
    None
}

/// Sends messages; `false` when the browser has gone or takes nothing.
async fn send(socket: &mut WebSocket, messages: Vec<Message>) -> bool {
    for message in messages {
        if !matches!(timeout(UNREAD, socket.send(message)).await, Ok(Ok(()))) {
            return false;
        }
    }
    true
}

async fn close(socket: &mut WebSocket, code: u16, reason: &'static str) {
    let frame = CloseFrame { code, reason: reason.into() };
    let _ = timeout(Duration::from_millis(200), socket.send(Message::Close(Some(frame)))).await;
}

impl Place {
    fn subscribe(&mut self, channel: Option<usize>, doppler: Option<bool>) {
        if let Some(channel) = channel.filter(|channel| *channel != self.channel) {
            (self.channel, self.row) = (channel, 0);
        }
        self.doppler = doppler.unwrap_or(self.doppler);
    }

    /// What is new, as much as an update holds.
    fn update(&mut self, hub: &Hub, ended: bool) -> Vec<Message> {
        let mut messages = Vec::new();
        if ended || self.ticks.is_multiple_of(STATUS_TICKS) {
            messages.push(Message::text(status::status(hub).to_string()));
        }
        if self.doppler {
            hub.watch_doppler(self.channel);
        }
        if self.ppi {
            hub.watch_ppi();
        }
        let state = hub.state();
        if ended || self.ticks.is_multiple_of(PLAN_TICKS) {
            self.plan(&state, &mut messages);
        }
        messages.extend(self.rows(&state, hub));
        if self.ppi {
            messages.extend(self.radials(&state, hub));
        }
        if let Some(map) = state
            .map
            .as_ref()
            .filter(|map| self.doppler && map.channel == self.channel && map.number != self.map)
        {
            self.map = map.number;
            let columns = map.levels.len() / map.rows.max(1);
            let mut bytes = head(2, map.channel, columns, map.rows, state.column_s);
            for value in [map.pulse as f64, map.time_s, map.start_s, map.span_hz] {
                bytes.extend(value.to_le_bytes());
            }
            bytes.extend(map.levels.iter().flat_map(|level| level.to_le_bytes()));
            messages.push(Message::binary(bytes));
        }
        self.ticks += 1;
        messages
    }

    fn plan(&mut self, state: &State, messages: &mut Vec<Message>) {
        let history = &state.history;
        let points = history.points();
        let first = if self.epoch == Some(history.epoch()) { self.points } else { 0 };
        if first < points.len() {
            let new = status::history(&points[first..], history.epoch(), first);
            messages.push(Message::text(new.to_string()));
        }
        (self.epoch, self.points) = (Some(history.epoch()), points.len());
        if let Some(now) = state.now.as_ref().filter(|now| self.pulse != Some(now.pulse)) {
            self.pulse = Some(now.pulse);
            messages.push(Message::text(status::now(now).to_string()));
        }
    }

    /// Range lines that the browser has not seen.
    fn rows(&mut self, state: &State, hub: &Hub) -> Option<Message> {
        let rows = state.rows.get(self.channel)?;
        let from = unseen(self.row, rows.front()?.number, hub);
        let new: Vec<_> = rows.iter().skip(from).take(ROWS).collect();
        let columns = new.first()?.levels.len();
        self.row = new.last()?.number;
        let mut bytes = head(1, self.channel, columns, new.len(), state.column_s);
        for row in new {
            for value in [row.pulse as f64, row.time_s, row.start_s] {
                bytes.extend(value.to_le_bytes());
            }
            bytes.extend(row.levels.iter().flat_map(|level| level.to_le_bytes()));
        }
        Some(Message::binary(bytes))
    }

    /// Radials that the browser has not seen.
    fn radials(&mut self, state: &State, hub: &Hub) -> Option<Message> {
        let radials = &state.radials;
        let from = unseen(self.radial, radials.front()?.number, hub);
        let new: Vec<_> = radials.iter().skip(from).take(RADIALS).collect();
        let columns = new.iter().map(|radial| radial.codes.len()).max()?;
        self.radial = new.last()?.number;
        let mut bytes = head(3, 0, columns, new.len(), hub.ppi_cell_s);
        for radial in new {
            for value in [
                radial.pulse as f64,
                radial.time_s,
                radial.start_s,
                radial.azimuth_deg,
                radial.heading_deg,
                radial.peak_dbw,
            ] {
                bytes.extend(value.to_le_bytes());
            }
            let missing = columns - radial.codes.len();
            bytes.extend(radial.codes.iter().copied().chain(std::iter::repeat_n(0, missing)));
        }
        Some(Message::binary(bytes))
    }
}

/// Place of the first entry after the last one seen in a buffer that begins with the oldest; those that have
/// gone from it are counted.
fn unseen(seen: u64, oldest: u64, hub: &Hub) -> usize {
    if seen > 0 && oldest > seen + 1 {
        hub.left_out.fetch_add(oldest - seen - 1, Ordering::Relaxed);
    }
    usize::try_from((seen + 1).saturating_sub(oldest)).unwrap_or(usize::MAX)
}

/// Begin of a binary message: kind, channel, columns, rows, delay from a column to the next.
fn head(kind: u8, channel: usize, columns: usize, rows: usize, column_s: f64) -> Vec<u8> {
    let short = |value: usize| u16::try_from(value).unwrap_or(u16::MAX).to_le_bytes();
    let mut bytes = vec![kind, 0];
    bytes.extend([short(channel), short(columns), short(rows)].concat());
    bytes.extend(column_s.to_le_bytes());
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::monitor::about::Scenery;
    use crate::monitor::ranges::Row;
    use crate::pulse::Layout;
    use crate::recording::header::Header;

    /// Who looks rarely is sent what is still held, and no more than that at once.
    #[test]
    fn a_slow_browser_leaves_out() {
        let header =
            Header { layout: Layout { channels: 1, samples: 4, ..Layout::default() }, ..Header::default() };
        let hub = Hub::new(&header, &Scenery::default(), None);
        let fill = |pulses: std::ops::Range<u64>| {
            for pulse in pulses {
                hub.state().push_row(0, Row { pulse, levels: vec![1, 2], ..Row::default() });
            }
        };
        fill(0..3);
        let mut place = Place::default();
        let bytes = |place: &mut Place| place.rows(&hub.state(), &hub).map(|message| message.into_data());
        let first = bytes(&mut place).unwrap();
        assert_eq!((first[0], first[6], first.len()), (1, 3, 16 + 3 * (24 + 4)));
        assert!(bytes(&mut place).is_none());
        fill(3..2003);
        let next = bytes(&mut place).unwrap();
        assert_eq!(usize::from(next[6]), ROWS);
        assert_eq!(hub.left_out.load(Ordering::Relaxed), 2000 - 400);
        assert_eq!(f64::from_le_bytes(next[16..24].try_into().unwrap()), 1603.0);
        // Another channel begins with all that is held.
        place.subscribe(Some(7), None);
        assert!(bytes(&mut place).is_none() && place.row == 0);
    }
}
