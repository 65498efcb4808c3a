//! Who is answered.
//!
//! * The page, its parts and its socket have a random token in their path, made for every run: whoever was
//!   not shown the address knows none of them. Figures for dashboards (`/api/status`, `/metrics`) have none.
//! * The `Host` must be an IP address or `localhost`. A page of somebody else whose name is made to lead here
//!   (DNS rebinding) gives its own name.
//! * An `Origin`, which browsers send with every request across pages, must be this page's own.

use std::net::IpAddr;

use super::MonitorFault;

/// Random bytes of a token.
const TOKEN_BYTES: usize = 16;

/// A new token: 128 random bits as hexadecimal digits.
pub fn token() -> Result<String, MonitorFault> {
    let mut bytes = [0; TOKEN_BYTES];
    getrandom::fill(&mut bytes).map_err(MonitorFault::Random)?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

/// Whether a token is the right one, in a time that does not depend on where it is wrong.
pub fn is_token(given: &str, token: &str) -> bool {
    given.len() == token.len() && given.bytes().zip(token.bytes()).fold(0, |all, (a, b)| all | (a ^ b)) == 0
}

/// Whether a `Host` names this machine by number.
pub fn is_host(host: &str) -> bool {
    let (name, port) = match host.rsplit_once(':') {
        Some((name, port)) if !port.contains(']') => (name, Some(port)),
        _ => (host, None),
    };
    if port.is_some_and(|port| port.parse::<u16>().is_err()) {
        return false;
    }
    match name.strip_prefix('[').and_then(|name| name.strip_suffix(']')) {
        Some(inner) => inner.parse::<std::net::Ipv6Addr>().is_ok(),
        None => name.eq_ignore_ascii_case("localhost") || matches!(name.parse(), Ok(IpAddr::V4(_))),
    }
}

/// Whether an `Origin` is that of the page itself.
pub fn is_origin(origin: &str, host: &str) -> bool {
    origin.strip_prefix("http://").is_some_and(|from| from.eq_ignore_ascii_case(host))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_differ_and_only_the_right_one_is_taken() {
        let (one, other) = (token().unwrap(), token().unwrap());
        assert_eq!(one.len(), 32);
        assert!(is_token(&one, &one) && !is_token(&other, &one) && !is_token("", &one));
        assert!(!is_token(&one[..31], &one) && !is_token(&one.to_uppercase(), "abc"));
    }

    #[test]
    fn hosts_are_numbers_or_localhost() {
        for host in ["127.0.0.1:8080", "localhost", "LOCALHOST:9", "[::1]:8080", "192.168.1.7:80", "[::1]"] {
            assert!(is_host(host), "{host}");
        }
        for host in [
            "evil.example:8080",
            "",
            "127.0.0.1.evil.example",
            "localhost.",
            "::1:8080",
            "127.0.0.1:x",
            "127.0.0.1:",
            "a@127.0.0.1",
            "[127.0.0.1]:80",
        ] {
            assert!(!is_host(host), "{host}");
        }
    }

    #[test]
    fn only_the_own_page_is_an_origin() {
        assert!(is_origin("http://127.0.0.1:8080", "127.0.0.1:8080"));
        for origin in ["null", "http://evil.example", "https://127.0.0.1:8080", "http://127.0.0.1:8081", ""] {
            assert!(!is_origin(origin, "127.0.0.1:8080"), "{origin}");
        }
    }
}
