//! The live page, as browsers and those who pose as browsers see it.

use std::fs;
use std::io::{ErrorKind, Read, Write};
use std::net::TcpListener;
use std::path::Path;
use std::process::Command;
use std::thread;
use std::time::{Duration, Instant};

use crate::monitor_client::{Browser, Message, SCENARIO, body, code, connection, get, raw, served, shown};
use crate::program::{nereus, started};

/// The page and its parts come with their types and a strict policy; nothing else comes, however it is asked.
#[test]
fn the_page_is_all_there_is() {
    let shown = shown(&[]);
    let (status, page) = get(&shown.address, &shown.path(""), "");
    assert_eq!(status, 200, "{page}");
    for wanted in [
        "content-type: text/html",
        "default-src 'none'; script-src 'self'",
        "frame-ancestors 'none'",
        "x-content-type-options: nosniff",
        "referrer-policy: no-referrer",
        "cache-control: no-store",
    ] {
        assert!(page.contains(wanted), "{wanted}: {page}");
    }
    assert!(!page.to_lowercase().contains("access-control-allow"), "{page}");
    // The address as it may be copied, without its end.
    let (status, answer) = get(&shown.address, &format!("/{}", shown.token), "");
    assert!(status == 307 && answer.contains(&format!("location: /{}/\r\n", shown.token)), "{answer}");
    for (part, kind) in
        [("main.js", "text/javascript"), ("style.css", "text/css"), ("icon.svg", "image/svg+xml")]
    {
        let (status, answer) = get(&shown.address, &shown.path(part), "");
        assert!(status == 200 && answer.contains(&format!("content-type: {kind}")), "{part}: {answer}");
    }
    let tricks = [
        "../Cargo.toml",
        "../../../../etc/passwd",
        "..%2f..%2fetc%2fpasswd",
        "%2e%2e/%2e%2e/etc/passwd",
        "/etc/passwd",
        "//etc/passwd",
        "main.js%00",
        "main.js/",
        "./main.js",
        "page.toml",
        "socket",
        "index.html",
        "..",
        ".",
        "%",
        "%ff",
        "\\..\\x",
        "main.js?x=/etc/passwd#",
        "C:/x",
        "~/x",
    ];
    for trick in tricks {
        let (status, answer) = get(&shown.address, &shown.path(trick), "");
        let is_part = trick.starts_with("main.js?");
        assert_eq!(status == 200, is_part, "{trick}: {answer}");
        assert!(!answer.contains("root:") && !answer.contains("[scene]"), "{trick}: {answer}");
    }
    for path in [
        "/etc/passwd",
        "/..",
        "/page.toml",
        "/api/../etc/passwd",
        "/api",
        "/api/status/x",
        "*",
        "http://evil.example/metrics",
    ] {
        assert_ne!(get(&shown.address, path, "").0, 200, "{path}");
    }
}

/// Whoever lacks the token, comes from another page or under another name is refused, and can change nothing.
#[test]
fn who_does_not_belong_is_refused() {
    let shown = shown(&["--monitor-control"]);
    let address = &shown.address;
    let wrong = "0".repeat(32);
    for path in
        ["/", &format!("/{wrong}/"), &format!("/{wrong}/main.js"), &format!("/{}/", &shown.token[..31])]
    {
        assert_eq!(get(address, path, "").0, 403, "{path}");
    }
    let page = shown.path("");
    let port = address.rsplit(':').next().unwrap();
    for (host, expected) in [
        ("evil.example".to_owned(), 403),
        (format!("evil.example:{port}"), 403),
        (format!("127.0.0.1.evil.example:{port}"), 403),
        (String::new(), 403),
        (format!("localhost:{port}"), 200),
        (format!("[::1]:{port}"), 200),
    ] {
        for path in [page.as_str(), "/metrics", "/api/status"] {
            assert_eq!(get(address, path, &format!("Host: {host}\r\n")).0, expected, "{host} {path}");
        }
    }
    let two = format!("Host: {address}\r\nHost: evil.example\r\n");
    assert_ne!(get(address, &page, &two).0, 200);
    assert_ne!(code(&raw(address, format!("GET {page} HTTP/1.0\r\n\r\n").as_bytes())), 200);
    for origin in ["http://evil.example", "null", "https://127.0.0.1", &format!("http://localhost:{port}")] {
        let from = format!("Origin: {origin}\r\n");
        assert_eq!(get(address, &page, &from).0, 403, "{origin}");
        assert_eq!(get(address, "/api/status", &from).0, 403, "{origin}");
        assert_eq!(Browser::open(address, &shown.token, &from).err(), Some(403), "{origin}");
    }
    assert_eq!(Browser::open(address, &wrong, "").err(), Some(403));
    for method in ["POST", "PUT", "DELETE", "TRACE", "OPTIONS", "CONNECT", "BREW"] {
        let asked = format!("{method} {page} HTTP/1.1\r\nHost: {address}\r\nContent-Length: 4\r\n\r\nstop");
        let answer = raw(address, asked.as_bytes());
        assert!(matches!(code(&answer), 0 | 400 | 403..=405), "{method}: {answer}");
    }
    // Who belongs is let in all the same, and nobody else has changed anything.
    assert_eq!(shown.browser().json("status")["changes"].as_array().map(Vec::len), Some(0));
}

/// A target stands at its true delay to a cell, in a range line of the very pulse.
#[test]
fn a_browser_sees_the_run() {
    let shown = shown(&[]);
    let mut browser = shown.browser();
    let about = browser.json("about");
    assert_eq!((&about["title"], &about["control"]), (&"page.toml".into(), &false.into()));
    assert_eq!(about["channels"][1]["name"], "VV");
    browser.send(r#"{"channel":1,"doppler":true}"#);
    let now = browser.json("now");
    let delay_s = now["delays_s"][0].as_f64().unwrap();
    let pulse = now["pulse"].as_u64().unwrap();
    let line = browser.until(|message| match message {
        Message::Lines(lines) => lines.iter().find(|line| line.pulse >= pulse).map(|line| {
            let peak =
                (0..line.levels_dbw.len()).max_by(|a, b| line.levels_dbw[*a].total_cmp(&line.levels_dbw[*b]));
            let (pulses, peak) = (line.pulse - pulse, peak.unwrap());
            // 50 m/s across the line of sight: less than 0.2 ns a pulse.
            let moved_s = pulses as f64 * 2e-9;
            ((line.start_s + (peak as f64 + 0.5) * line.step_s - delay_s).abs(), moved_s, line.step_s)
        }),
        _ => None,
    });
    // A column is a cell here; the peak stands in the one that holds the delay, but for noise.
    assert!(line.0 <= 0.6 * line.2 + line.1, "{line:?}");
    assert!(line.2 <= 1e-8, "{line:?}");
    let (rows, span_hz) = browser.until(|message| match message {
        Message::Map { rows, span_hz } => Some((*rows, *span_hz)),
        _ => None,
    });
    assert_eq!((rows, span_hz), (128, 100.0));
    let history = browser.json("history");
    assert_eq!(history["points"][0].as_array().map(Vec::len), Some(2 + 2 * 16));
    // Pulses move on, and the end is announced.
    let first = browser.json("status")["released"].as_u64().unwrap();
    // On a busy machine not from one message to the next.
    browser.until(|message| match message {
        Message::Json(value) => value["released"].as_u64().filter(|now| *now > first),
        _ => None,
    });
    let id = shown.child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    let last = browser.until(|message| match message {
        Message::Json(value) if value["ended"] == true => Some(value.clone()),
        _ => None,
    });
    assert_eq!(last["losses"].as_array().map(Vec::len), Some(0));
    assert_eq!(browser.closed(), 1000);
}

/// What is asked from the page is a change like any other: with the pulse from which it acts, in the errors
/// shown and in the report. Without leave nothing is changed.
#[test]
fn a_change_from_the_page_is_seen_and_logged() {
    let with = shown(&["--monitor-control"]);
    let mut browser = with.browser();
    assert_eq!(browser.json("about")["control"], true);
    while browser.json("status")["released"].as_u64().unwrap() == 0 {}
    browser.send(r#"{"change":"step position.up 5 m on aircraft"}"#);
    let text = browser.json("answer")["text"].as_str().unwrap().to_owned();
    let pulse: u64 = text.split(' ').nth(2).unwrap().parse().unwrap();
    assert_eq!(text, format!("ok pulse {pulse} step position.up 5 m on aircraft"));
    browser.send(r#"{"change":"step position.up 5 deg on aircraft"}"#);
    let refused = browser.json("answer")["text"].as_str().unwrap().to_owned();
    assert_eq!(refused, "error unit 'deg' of position.up: allowed: m");
    for (line, expected) in [
        ("stop", "error 'stop'"),
        ("status", "error 'status'"),
        ("", "error ''"),
        ("clear\\non aircraft", "error a change with control characters"),
        ("bias position.up 1 m on aircraft\\nstop", "error a change with control characters"),
        ("step position.up 1e309 m on aircraft", "error value '1e309'"),
    ] {
        browser.send(&format!(r#"{{"change":"{line}"}}"#));
        let refused = browser.json("answer")["text"].as_str().unwrap().to_owned();
        assert!(refused.starts_with(expected), "{line}: {refused}");
    }
    // Two at once: both are answered, and both changes are made.
    let mut others = [with.browser(), with.browser()];
    others.iter_mut().for_each(|other| other.send(r#"{"change":"clear on mast"}"#));
    let mut newest = pulse;
    for other in &mut others {
        let text = other.json("answer")["text"].as_str().unwrap().to_owned();
        newest = newest.max(text.split(' ').nth(2).unwrap().parse().unwrap());
        assert!(text.starts_with("ok pulse ") && text.ends_with(" clear on mast"), "{text}");
    }
    let status = browser.until(|message| match message {
        Message::Json(value) if value["misreported"].as_array().is_some_and(|all| !all.is_empty()) => {
            Some(value.clone())
        }
        _ => None,
    });
    let one = &status["misreported"][0];
    assert_eq!((&one["platform"], &one["quantity"]), (&"aircraft".into(), &"position".into()));
    assert_eq!((&one["direction"], one["since_pulse"].as_u64()), (&"too high".into(), Some(pulse)));
    // Each point: pulse, time, 16 values a platform; 6 to 8 are the error of position. The report has the
    // changes of pulses that were released.
    let mut points = Vec::new();
    while points.last().is_none_or(|(last, _)| *last < newest + 20) {
        let history = browser.json("history");
        let new = history["points"].as_array().unwrap().iter();
        points.extend(new.map(|row| (row[0].as_f64().unwrap() as u64, row[2 + 16 + 8].as_f64().unwrap())));
    }
    for (at, up_m) in points {
        assert!((up_m - if at >= pulse { 5.0 } else { 0.0 }).abs() < 1e-3, "{at} {up_m}");
    }
    let report = with.end();
    assert_eq!(report["changes"][0]["pulse"].as_u64(), Some(pulse));
    assert_eq!(
        (&report["changes"][0]["source"], report["changes"].as_array().map(Vec::len)),
        (&"control".into(), Some(3))
    );

    let without = shown(&[]);
    let mut browser = without.browser();
    browser.send(r#"{"change":"clear on mast"}"#);
    let refused = browser.json("answer")["text"].as_str().unwrap().to_owned();
    assert!(refused.starts_with("error ") && refused.contains("--monitor-control"), "{refused}");
    assert_eq!(without.end()["changes"].as_array().map(Vec::len), Some(0));
}

/// Resident memory of a process, bytes.
#[cfg(target_os = "linux")]
fn resident(id: u32) -> u64 {
    let text = fs::read_to_string(format!("/proc/{id}/status")).unwrap();
    let line = text.lines().find(|line| line.starts_with("VmRSS:")).unwrap();
    line.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap() << 10
}

/// Slow headers, huge headers and frames, floods, a thousand connections, a browser that stops reading: each
/// is refused or left, the run goes on, and who comes next is served.
#[test]
#[cfg(target_os = "linux")]
fn hostile_clients_do_no_harm() {
    let shown = shown(&["--monitor-control"]);
    let address = shown.address.clone();
    shown.browser().json("now");
    let before = resident(shown.child.id());

    // Some browsers that never read.
    let unread: Vec<Browser> = (0..8).map(|_| shown.browser()).collect();
    // A header that never ends is not waited for longer than its time.
    let begun = Instant::now();
    let mut slow: Vec<_> = (0..20).map(|_| connection(&address)).collect();
    slow.iter_mut().for_each(|stream| stream.write_all(b"GET / HT").unwrap());
    let dripping = thread::spawn(move || {
        let mut open = slow;
        while !open.is_empty() && begun.elapsed() < Duration::from_secs(30) {
            thread::sleep(Duration::from_millis(300));
            open.retain_mut(|stream| stream.write_all(b"x").is_ok());
        }
        (open.len(), begun.elapsed())
    });
    // A header without end.
    let endless = format!("GET / HTTP/1.1\r\nHost: {address}\r\nX: {}\r\n\r\n", "x".repeat(1 << 20));
    assert!(matches!(code(&raw(&address, endless.as_bytes())), 0 | 400 | 431));
    let many = format!("GET / HTTP/1.1\r\nHost: {address}\r\n{}\r\n", "a: b\r\n".repeat(2000));
    assert!(matches!(code(&raw(&address, many.as_bytes())), 0 | 400 | 431));
    assert!(matches!(code(&raw(&address, &[0; 4096])), 0 | 400));
    // A body without end is not read, and of many requests at once one is answered.
    let mut flood = connection(&address);
    let ask = format!("POST / HTTP/1.1\r\nHost: {address}\r\nTransfer-Encoding: chunked\r\n\r\n");
    flood.write_all(ask.as_bytes()).unwrap();
    let chunk = [b"10000\r\n".as_slice(), &[b'x'; 1 << 16], b"\r\n"].concat();
    let taken = (0..2000).take_while(|_| flood.write_all(&chunk).is_ok()).count();
    assert!(taken < 1000, "{taken} chunks of 64 KiB");
    let many = format!("GET /metrics HTTP/1.1\r\nHost: {address}\r\n\r\n").repeat(50);
    assert_eq!(raw(&address, many.as_bytes()).matches("HTTP/1.1 ").count(), 1);
    assert!(matches!(code(&raw(&address, b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03")), 0 | 400));

    // Frames that are too long, of the wrong kind, no text, not the page's, or too many.
    type Act = fn(&mut Browser);
    let bad: [(&str, Act); 6] = [
        ("a frame of 2^62 bytes", |browser| drop(browser.frame(1, 1 << 62, b"{"))),
        ("a frame of 64 KiB", |browser| drop(browser.frame(1, 65_535, &[b' '; 65_535]))),
        ("a binary frame", |browser| drop(browser.frame(2, 2, b"{}"))),
        ("no UTF-8", |browser| drop(browser.frame(1, 2, b"\xff\xfe"))),
        ("not of the page", |browser| browser.send(r#"{"open":"/etc/passwd"}"#)),
        ("a flood", |browser| (0..200).for_each(|_| drop(browser.frame(1, 2, b"{}")))),
    ];
    for (what, act) in bad {
        let mut browser = shown.browser();
        act(&mut browser);
        let code = browser.closed();
        assert!(matches!(code, 0 | 1002 | 1003 | 1007..=1009), "{what}: {code}");
    }

    // A thousand connections: those beyond the limit are closed at once, and the rest when their time is up.
    let crowd: Vec<_> = (0..1000).filter_map(|_| std::net::TcpStream::connect(&address).ok()).collect();
    let (left, took) = dripping.join().unwrap();
    assert_eq!(left, 0, "slow headers are still waited for after {took:?}");
    let ends = |mut stream: &std::net::TcpStream| {
        stream.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
        let ended = stream.read(&mut [0; 512]);
        !ended.is_err_and(|error| matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut))
    };
    assert!(crowd.len() > 900 && crowd.iter().all(ends), "some of {} are still held", crowd.len());
    drop(crowd);

    // The others have gone: who comes now is served, and the run is as it was.
    let begun = Instant::now();
    while get(&address, "/api/status", "").0 != 200 {
        assert!(begun.elapsed() < Duration::from_secs(30), "nobody is served any more");
        thread::sleep(Duration::from_millis(100));
    }
    let mut browser = shown.browser();
    let status = browser.json("status");
    assert_eq!((status["dropped"].as_u64(), status["losses"].as_array().map(Vec::len)), (Some(0), Some(0)));
    let grown = resident(shown.child.id()).saturating_sub(before);
    assert!(grown < 64 << 20, "{grown} bytes more");
    drop(unread);
    let report = shown.end();
    assert_eq!((&report["dropped"], &report["sinks"][0]["dropped"]), (&0.into(), &0.into()));
    assert_eq!(report["changes"].as_array().map(Vec::len), Some(0));
}

/// A message of empty frames never becomes long, and its end need not come: the connection ends instead.
#[test]
fn a_message_without_end_ends_its_connection() {
    let shown = shown(&[]);
    let mut browser = shown.browser();
    browser.fragment(1).unwrap();
    // Far more than the system holds of what nobody reads.
    let begun = Instant::now();
    let taken = (0..4_000_000).take_while(|_| browser.fragment(0).is_ok()).count();
    println!("{taken} frames taken in {:?}", begun.elapsed());
    assert!(taken < 4_000_000);
    // One whose messages end may go on for as long as it likes.
    let mut browser = shown.browser();
    for channel in (0..3).cycle().take(30) {
        browser.fragment(1).unwrap();
        (0..300).for_each(|_| browser.fragment(0).unwrap());
        let rest = format!(r#"{{"channel":{channel}}}"#);
        browser.frame(0, rest.len() as u64, rest.as_bytes()).unwrap();
        thread::sleep(Duration::from_millis(60));
    }
    browser.json("status");
    shown.end();
}

/// More browsers than are allowed get an error.
#[test]
fn no_more_browsers_than_there_may_be() {
    let shown = shown(&[]);
    let mut all: Vec<Browser> = (0..16).map(|_| shown.browser()).collect();
    assert_eq!(Browser::open(&shown.address, &shown.token, "").err(), Some(503));
    all.iter_mut().for_each(|browser| drop(browser.json("about")));
    drop(all);
    let begun = Instant::now();
    while Browser::open(&shown.address, &shown.token, "").is_err() {
        assert!(begun.elapsed() < Duration::from_secs(20), "places are not given back");
        thread::sleep(Duration::from_millis(50));
    }
}

#[test]
fn figures_for_dashboards() {
    let shown = shown(&[]);
    let mut browser = shown.browser();
    while browser.json("status")["released"].as_u64().unwrap() < 20 {}
    let (status, answer) = get(&shown.address, "/api/status", "");
    assert!(status == 200 && answer.contains("content-type: application/json"), "{answer}");
    let figures: serde_json::Value = serde_json::from_str(body(&answer)).unwrap();
    for key in ["released", "late", "dropped", "made", "elapsed_s"] {
        assert!(figures[key].is_number(), "{key}: {figures}");
    }
    assert_eq!(
        (&figures["sinks"][0]["name"], &figures["navigation"][1]["platform"]),
        (&"null".into(), &"aircraft".into())
    );
    assert_eq!(figures["monitor"]["browsers"], 1);
    let text = figures.to_string();
    assert!(!text.contains(&shown.token) && !text.contains("page.toml"), "{text}");

    let (status, answer) = get(&shown.address, "/metrics", "");
    assert!(status == 200 && answer.contains("content-type: text/plain; version=0.0.4"), "{answer}");
    let mut value = std::collections::BTreeMap::new();
    let mut described = std::collections::BTreeSet::new();
    for line in body(&answer).lines() {
        if let Some(rest) = line.strip_prefix("# ") {
            let words: Vec<&str> = rest.splitn(3, ' ').collect();
            assert!(["HELP", "TYPE"].contains(&words[0]) && words.len() == 3, "{line}");
            // Once each, and what only grows says so in its name.
            assert!(described.insert((words[0].to_owned(), words[1].to_owned())), "{line}");
            assert!(words[0] == "HELP" || (words[2] == "counter") == words[1].ends_with("_total"), "{line}");
            continue;
        }
        let (name, number) = line.rsplit_once(' ').unwrap();
        let family = name.split('{').next().unwrap();
        let base =
            ["_bucket", "_sum", "_count"].iter().find_map(|end| family.strip_suffix(end)).unwrap_or(family);
        let is_described = |name: &str| {
            ["HELP", "TYPE"].iter().all(|word| described.contains(&((*word).to_owned(), name.to_owned())))
        };
        assert!(is_described(base) || is_described(family), "{line}");
        assert!(name.bytes().next().is_some_and(|byte| byte.is_ascii_alphabetic()), "{line}");
        let twice = value.insert(name.to_owned(), number.parse::<f64>().unwrap());
        assert!(twice.is_none(), "{line}");
    }
    let buckets: Vec<f64> = body(&answer)
        .lines()
        .filter_map(|line| {
            line.strip_prefix("nereus_lateness_seconds_bucket")?.rsplit(' ').next()?.parse().ok()
        })
        .collect();
    assert!(buckets.len() == 23 && buckets.is_sorted(), "{buckets:?}");
    assert_eq!(value["nereus_lateness_seconds_bucket{le=\"+Inf\"}"], value["nereus_lateness_seconds_count"]);
    assert!(value["nereus_pulses_released_total"] >= 20.0);
    assert!(value.contains_key("nereus_lateness_seconds_bucket{le=\"0.001\"}"));
    assert!(value.contains_key("nereus_sink_dropped_total{sink=\"null\"}"));
}

/// What is no address, in use or not this machine's is refused before anything is made.
#[test]
fn addresses_that_cannot_be_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(
        folder.path().join("page.toml"),
        SCENARIO.replace("kind = \"null\"", "kind = \"plain\"\npath = \"out\""),
    )
    .unwrap();
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let in_use = taken.local_addr().unwrap().to_string();
    for (given, wanted) in [
        ("8080", "allowed: HOST:PORT such as 127.0.0.1:8080"),
        ("127.0.0.1:99999", "allowed: HOST:PORT"),
        ("", "allowed: HOST:PORT"),
        ("192.0.2.1:8080", "allowed: an address of this machine"),
        (in_use.as_str(), "is in use: another program listens there"),
    ] {
        let ended = nereus(folder.path(), &["run", "page.toml", "--monitor", given]);
        assert_eq!(ended.code, 2, "{given}: {}", ended.stderr);
        assert!(
            ended.stderr.contains(wanted) && ended.stderr.contains(&format!("'{given}'")),
            "{given}: {}",
            ended.stderr
        );
    }
    let ended = nereus(folder.path(), &["run", "page.toml", "--monitor-control"]);
    assert!(ended.code == 2 && ended.stderr.contains("--monitor ADDR or stream.monitor"), "{}", ended.stderr);
    let ended = nereus(folder.path(), &["run", "page.toml", "--set", "stream.monitor=nowhere"]);
    assert!(ended.code == 2 && ended.stderr.contains("stream.monitor"), "{}", ended.stderr);
    let key = format!("stream.monitor=\"{in_use}\"");
    let ended = nereus(folder.path(), &["run", "page.toml", "--set", &key]);
    assert!(ended.code == 2 && ended.stderr.contains("is in use"), "{}", ended.stderr);
    assert!(!folder.path().join("out").exists());
}

fn recorded(folder: &Path, out: &str) {
    fs::write(folder.join("page.toml"), SCENARIO).unwrap();
    let event = "event=[{pulse=30,platform=\"aircraft\",change=\"step position.north -3 m\"}]";
    let run = ["run", "page.toml", "--pace", "fast", "--pulses", "0..80", "--out", out, "--set", event];
    let ended = nereus(folder, &run);
    assert_eq!(ended.code, 0, "{}", ended.stderr);
}

/// A recording is shown at its pace or faster, with its changes; one that was cut as far as it goes.
#[test]
fn a_recording_is_shown_as_a_run_is() {
    let formats: &[&str] = if cfg!(feature = "hdf5") { &["made.plain", "made.h5"] } else { &["made.plain"] };
    for out in formats {
        let folder = tempfile::tempdir().unwrap();
        recorded(folder.path(), out);
        let child = started(folder.path(), &["monitor", out, "--listen", "127.0.0.1:0", "--speed", "0.5"]);
        let shown = served(folder, child);
        let mut browser = shown.browser();
        let about = browser.json("about");
        assert_eq!(
            (&about["title"], &about["replayed"], &about["control"]),
            (&(*out).into(), &true.into(), &false.into())
        );
        assert_eq!(about["targets"][0]["position_m"][0], 5000.0);
        let line = browser.until(|message| match message {
            Message::Lines(lines) => {
                lines.first().map(|line| line.levels_dbw.iter().copied().fold(f64::MIN, f64::max))
            }
            _ => None,
        });
        assert!(line > -120.0, "{line}");
        let status = browser.until(|message| match message {
            Message::Json(value) if value["misreported"].as_array().is_some_and(|all| !all.is_empty()) => {
                Some(value.clone())
            }
            _ => None,
        });
        let one = &status["misreported"][0];
        assert_eq!((&one["direction"], one["since_pulse"].as_u64()), (&"too far south".into(), Some(30)));
        assert_eq!(status["changes"][0]["source"], "scenario");
        while browser.json("status")["released"].as_u64().unwrap() < 80 {}
        // The page stays when the recording has ended.
        thread::sleep(Duration::from_millis(200));
        assert_eq!(get(&shown.address, &shown.path(""), "").0, 200);
    }
    let folder = tempfile::tempdir().unwrap();
    recorded(folder.path(), "cut.plain");
    let index = folder.path().join("cut.plain/pulse/index.bin");
    let bytes = fs::read(&index).unwrap();
    fs::write(&index, &bytes[..bytes.len() - 8 * 50 - 3]).unwrap();
    let ended = nereus(
        folder.path(),
        &["monitor", "cut.plain", "--listen", "127.0.0.1:0", "--speed", "1000", "--once"],
    );
    assert_eq!(ended.code, 0, "{}", ended.stderr);
    assert!(ended.stderr.contains("29 pulses shown"), "{}", ended.stderr);
    let ended = nereus(folder.path(), &["monitor", "nowhere", "--listen", "127.0.0.1:0"]);
    assert_eq!(ended.code, 2, "{}", ended.stderr);
    let none = nereus(folder.path(), &["monitor", "cut.plain", "--speed", "0"]);
    assert!(none.code == 2 && none.stderr.contains("0.001 to 1000"), "{}", none.stderr);
}

/// The scenario's own key serves the page as well; the run makes the same pulses with it and without.
#[test]
fn a_page_changes_no_pulse() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("page.toml"), SCENARIO).unwrap();
    let run = ["run", "page.toml", "--pace", "fast", "--pulses", "0..60"];
    let with = [&run[..], &["--out", "with.plain", "--monitor", "127.0.0.1:0"]].concat();
    let without = [&run[..], &["--out", "without.plain"]].concat();
    for arguments in [with, without] {
        let ended = nereus(folder.path(), &arguments);
        assert_eq!(ended.code, 0, "{}", ended.stderr);
    }
    let read = |out: &str| {
        let files = ["iq.bin", "pulse/flags.bin", "pulse/time_ns.bin"];
        files.map(|file| fs::read(folder.path().join(out).join(file)).unwrap())
    };
    assert!(read("with.plain") == read("without.plain"));
}
