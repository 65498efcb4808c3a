//! Answers browsers, within limits.
//!
//! One thread of lowest priority. A connection serves one request, has seconds to send its header and to take
//! its answer; headers, frames and the number of connections are bounded, and what goes beyond is closed.
//! Nothing that is asked leads to the file system.

use std::io;
use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use axum::extract::ws::WebSocketUpgrade;
use axum::extract::{Path, Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::middleware::{Next, from_fn};
use axum::response::{IntoResponse, Redirect, Response};
use axum::routing::get;
use axum::{Extension, Router};
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::sync::{Notify, Semaphore};

use super::hub::Hub;
use super::meter::{Meter, Metered};
use super::{MonitorFault, assets, client, guard, metrics, status, watch};

/// Connections at a time, those of browsers that look on apart.
const CONNECTIONS: usize = 64;
/// Browsers that look on.
const BROWSERS: usize = 16;
/// Time in which a header must have come.
const HEADER: Duration = Duration::from_secs(5);
/// Time in which a request must have been answered.
const ANSWER: Duration = Duration::from_secs(15);
/// Longest header, bytes.
const HEADER_BYTES: usize = 16 << 10;
/// Longest frame that a browser sends, bytes.
const FRAME_BYTES: usize = 4 << 10;
/// Most that waits to be sent to a browser, bytes.
const UNSENT_BYTES: usize = 4 << 20;
/// How long browsers may take for the last of a run.
const FAREWELL: Duration = Duration::from_millis(700);
/// Rest after a connection that the system did not give.
const REST: Duration = Duration::from_millis(50);

/// An address at which nobody is answered yet.
#[derive(Debug)]
pub struct Endpoint {
    listener: TcpListener,
    address: SocketAddr,
    token: String,
}

/// An address at which browsers are answered.
pub(super) struct Serving {
    over: Arc<Notify>,
    thread: Option<JoinHandle<()>>,
}

/// What requests are about.
#[derive(Clone)]
struct Subject {
    hub: Arc<Hub>,
    token: Arc<str>,
    browsers: Arc<Semaphore>,
}

impl Endpoint {
    /// Takes an address, such as `127.0.0.1:8080`.
    ///
    /// # Errors
    /// What is no address, is in use, or is not this machine's.
    pub fn at(given: &str) -> Result<Self, MonitorFault> {
        use std::net::ToSocketAddrs;
        let wrong = |source| MonitorFault::Address { given: given.to_owned(), source };
        let addresses: Vec<SocketAddr> = given.to_socket_addrs().map_err(wrong)?.collect();
        let listener = TcpListener::bind(&addresses[..]).map_err(|source| match source.kind() {
            io::ErrorKind::AddrInUse => MonitorFault::InUse { given: given.to_owned() },
            _ => MonitorFault::Listen { given: given.to_owned(), source },
        })?;
        let listen = |source| MonitorFault::Listen { given: given.to_owned(), source };
        listener.set_nonblocking(true).map_err(listen)?;
        let address = listener.local_addr().map_err(listen)?;
        Ok(Self { listener, address, token: guard::token()? })
    }

    /// Where browsers find it: with the token that lets them in.
    pub fn url(&self) -> String {
        format!("http://{}/{}/", self.address, self.token)
    }

    /// Whether other machines can reach it.
    pub fn is_open_to_others(&self) -> bool {
        !self.address.ip().is_loopback()
    }

    /// Answers from now on.
    ///
    /// # Errors
    /// The system refuses a thread.
    pub(super) fn serve(self, hub: Arc<Hub>) -> Result<Serving, MonitorFault> {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_io()
            .enable_time()
            .max_blocking_threads(2)
            .thread_name("monitor change")
            .build()
            .map_err(MonitorFault::Thread)?;
        let over = Arc::new(Notify::new());
        let ends = Arc::clone(&over);
        let subject = Subject {
            hub: Arc::clone(&hub),
            token: self.token.into(),
            browsers: Arc::new(Semaphore::new(BROWSERS)),
        };
        let listener = self.listener;
        let serve = move || {
            watch::step_back();
            runtime.block_on(async move {
                let Ok(listener) = tokio::net::TcpListener::from_std(listener) else { return };
                tokio::select! {
                    () = accept(&listener, &subject) => {}
                    () = ends.notified() => {}
                }
                drop(listener);
                let until = Instant::now() + FAREWELL;
                while hub.browsers.load(Ordering::Relaxed) > 0 && Instant::now() < until {
                    tokio::time::sleep(Duration::from_millis(20)).await;
                }
            });
            runtime.shutdown_background();
        };
        let thread = thread::Builder::new()
            .name("monitor server".to_owned())
            .spawn(serve)
            .map_err(MonitorFault::Thread)?;
        Ok(Serving { over, thread: Some(thread) })
    }
}

impl Serving {
    /// Answers nobody any more.
    pub fn close(&mut self) {
        self.over.notify_one();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Takes connections, no more than there may be.
async fn accept(listener: &tokio::net::TcpListener, subject: &Subject) {
    let connections = Arc::new(Semaphore::new(CONNECTIONS));
    let router = router(subject.clone());
    loop {
        let Ok((stream, _)) = listener.accept().await else {
            tokio::time::sleep(REST).await;
            continue;
        };
        let Ok(permit) = Arc::clone(&connections).try_acquire_owned() else {
            subject.hub.turned_away.fetch_add(1, Ordering::Relaxed);
            continue;
        };
        let meter = Meter::default();
        let service = TowerToHyperService::new(router.clone().layer(Extension(meter.clone())));
        let stream = Metered::new(stream, meter);
        tokio::spawn(async move {
            let connection = http1::Builder::new()
                .timer(TokioTimer::new())
                .header_read_timeout(HEADER)
                .max_buf_size(HEADER_BYTES)
                .keep_alive(false)
                .serve_connection(TokioIo::new(stream), service)
                .with_upgrades();
            let _ = tokio::time::timeout(ANSWER, connection).await;
            drop(permit);
        });
    }
}

fn router(subject: Subject) -> Router {
    Router::new()
        .route("/", get(front))
        .route("/api/status", get(api))
        .route("/metrics", get(figures))
        .route("/{token}", get(bare))
        .route("/{token}/", get(page))
        .route("/{token}/socket", get(socket))
        .route("/{token}/{part}", get(part))
        .fallback(async || refused(StatusCode::NOT_FOUND, "not found"))
        .with_state(subject)
        .layer(from_fn(guarded))
}

fn refused(status: StatusCode, why: &'static str) -> Response {
    (status, [(header::CONTENT_TYPE, "text/plain; charset=utf-8")], why).into_response()
}

/// Host and Origin are checked before anything else, and every answer states what the page may do.
async fn guarded(request: Request, next: Next) -> Response {
    let headers: &HeaderMap = request.headers();
    let text = |name| headers.get(name).map(|value: &HeaderValue| value.to_str().unwrap_or(""));
    let host = text(header::HOST).unwrap_or("").to_owned();
    let one = headers.get_all(header::HOST).iter().count() == 1;
    let own = request.uri().authority().is_none_or(|authority| authority.as_str() == host);
    let known = one && own && guard::is_host(&host);
    let mut answer = if !known {
        let why = "refused: the Host of a request must be an IP address or localhost";
        refused(StatusCode::FORBIDDEN, why)
    } else if text(header::ORIGIN).is_some_and(|origin| !guard::is_origin(origin, &host)) {
        refused(StatusCode::FORBIDDEN, "refused: this page answers no other one")
    } else {
        next.run(request).await
    };
    let own = if known { format!("ws://{host}") } else { String::new() };
    let policy = format!(
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; \
         connect-src 'self' {own}; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    );
    let policy = HeaderValue::from_str(&policy).unwrap_or(HeaderValue::from_static("default-src 'none'"));
    let fixed = [
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::X_FRAME_OPTIONS, "DENY"),
        (header::CACHE_CONTROL, "no-store"),
    ];
    let headers = answer.headers_mut();
    headers.insert(header::CONTENT_SECURITY_POLICY, policy);
    headers.insert("cross-origin-resource-policy", HeaderValue::from_static("same-origin"));
    for (name, value) in fixed {
        headers.insert(name, HeaderValue::from_static(value));
    }
    answer
}

async fn front() -> Response {
    refused(
        StatusCode::FORBIDDEN,
        "nereus: open the whole address that the run has printed: it ends in a token",
    )
}

async fn api(State(subject): State<Subject>) -> Response {
    let text = status::status(&subject.hub).to_string();
    ([(header::CONTENT_TYPE, "application/json")], text).into_response()
}

async fn figures(State(subject): State<Subject>) -> Response {
    let text = metrics::metrics(&subject.hub);
    ([(header::CONTENT_TYPE, "text/plain; version=0.0.4; charset=utf-8")], text).into_response()
}

impl Subject {
    fn serve(&self, token: &str, name: &str) -> Response {
        if !guard::is_token(token, &self.token) {
            return refused(StatusCode::FORBIDDEN, "refused: not the token of this run");
        }
        match assets::part(name) {
            Some((kind, content)) => ([(header::CONTENT_TYPE, kind)], content).into_response(),
            None => refused(StatusCode::NOT_FOUND, "not found"),
        }
    }
}

async fn page(State(subject): State<Subject>, Path(token): Path<String>) -> Response {
    subject.serve(&token, "")
}

/// The address without its last stroke leads to that with it: parts of the page are found beside it.
async fn bare(State(subject): State<Subject>, Path(token): Path<String>) -> Response {
    if !guard::is_token(&token, &subject.token) {
        return refused(StatusCode::FORBIDDEN, "refused: not the token of this run");
    }
    Redirect::temporary(&format!("/{token}/")).into_response()
}

async fn part(State(subject): State<Subject>, Path((token, name)): Path<(String, String)>) -> Response {
    // The page itself has one address.
    if name.is_empty() { refused(StatusCode::NOT_FOUND, "not found") } else { subject.serve(&token, &name) }
}

async fn socket(
    State(subject): State<Subject>,
    Path(token): Path<String>,
    Extension(meter): Extension<Meter>,
    upgrade: Result<WebSocketUpgrade, axum::extract::ws::rejection::WebSocketUpgradeRejection>,
) -> Response {
    if !guard::is_token(&token, &subject.token) {
        return refused(StatusCode::FORBIDDEN, "refused: not the token of this run");
    }
    let upgrade = match upgrade {
        Ok(upgrade) => upgrade,
        Err(rejection) => return rejection.into_response(),
    };
    let Ok(permit) = Arc::clone(&subject.browsers).try_acquire_owned() else {
        return refused(StatusCode::SERVICE_UNAVAILABLE, "16 browsers look on already: no more are served");
    };
    upgrade
        .max_message_size(FRAME_BYTES)
        .max_frame_size(FRAME_BYTES)
        .write_buffer_size(0)
        .max_write_buffer_size(UNSENT_BYTES)
        .on_upgrade(move |socket| client::serve(socket, subject.hub, meter, permit))
}
