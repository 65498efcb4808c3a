//! The live page: what a processor is fed, in a browser.
//!
//! ```text
//! pacer -> view (bounded, never waited for) -> watch: rows, maps, tracks -> Hub -> server -> browsers
//! recording -> replay --------------------------^
//! ```
//!
//! The monitor looks at the stream through a [view](crate::transport::view): a pulse for which it has no room
//! is left out there, and nothing that a browser does reaches the thread that releases pulses. `watch` takes
//! no more than a stated share of the machine for range compression (`budget`). Everything shown is held
//! once, in bounded buffers of the `hub`; each browser has a place in them and catches up by leaving out, so
//! that a slow one costs nothing.
//!
//! The page is embedded in the program (`assets`): nothing is read from the file system, whatever is asked.
//! Who may ask what is decided in `guard`.
#![cfg(feature = "monitor")]

mod about;
mod assets;
mod budget;
mod client;
mod doppler;
mod fault;
mod footprint;
mod guard;
mod history;
mod hub;
mod meter;
mod metrics;
mod misreport;
mod ppi;
mod ranges;
pub mod replay;
mod server;
mod status;
mod watch;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::thread::JoinHandle;

pub use about::Scenery;
pub use fault::MonitorFault;
pub use server::Endpoint;

use crate::pipeline::control::Control;
use crate::recording::header::Header;
use crate::transport::view::Onlooker;
use hub::Hub;

/// Memory of the pulses that wait for the monitor, bytes.
const QUEUE_BYTES: usize = 16 << 20;
/// Most pulses that wait for it.
const QUEUE_PULSES: usize = 256;

/// How many pulses may wait for the monitor of a run.
pub fn queue_pulses(header: &Header) -> usize {
    (QUEUE_BYTES / header.layout.slot_bytes().max(1)).clamp(4, QUEUE_PULSES)
}

/// A page that is being served.
pub struct Monitor {
    hub: Arc<Hub>,
    over: Arc<AtomicBool>,
    watching: Option<JoinHandle<()>>,
    server: server::Serving,
}

impl Monitor {
    /// Serves the page of a stream at an endpoint that has been opened. `control` lets who has the address
    /// change reports.
    ///
    /// # Errors
    /// The system refuses a thread.
    pub fn of_stream(
        endpoint: Endpoint,
        header: &Header,
        scenery: &Scenery,
        onlooker: Onlooker,
        control: Option<Control>,
    ) -> Result<Self, MonitorFault> {
        let hub = Arc::new(Hub::new(header, scenery, control));
        let over = Arc::new(AtomicBool::new(false));
        let server = endpoint.serve(Arc::clone(&hub))?;
        let watching = watch::start(onlooker, watch::Watcher::new(&hub, header, scenery), Arc::clone(&over))?;
        Ok(Self { hub, over, watching: Some(watching), server })
    }

    /// Serves the page of a recording; whoever plays it hands its pulses to the watcher.
    ///
    /// # Errors
    /// The system refuses a thread.
    fn of_recording(
        endpoint: Endpoint,
        header: &Header,
        scenery: &Scenery,
    ) -> Result<(Self, watch::Watcher), MonitorFault> {
        let hub = Arc::new(Hub::new(header, scenery, None));
        let server = endpoint.serve(Arc::clone(&hub))?;
        let watcher = watch::Watcher::new(&hub, header, scenery);
        Ok((Self { hub, over: Arc::default(), watching: None, server }, watcher))
    }

    /// Shows what is left, and ends.
    pub fn close(self) {}
}

impl Drop for Monitor {
    fn drop(&mut self) {
        self.over.store(true, std::sync::atomic::Ordering::Release);
        if let Some(thread) = self.watching.take() {
            let _ = thread.join();
        }
        self.hub.end();
        self.server.close();
    }
}
