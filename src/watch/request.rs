//! A browser's request, and the decision whether it is permitted.
//!
//! Any page that a user opens may send requests to this machine. A request is therefore served only if it contains the
//! token, which the command shows only to its user. Its host must also be the address of this server, which excludes
//! foreign names that resolve to it, and its origin must be this server or missing.

use std::io::{self, ErrorKind, Read};
use std::net::SocketAddr;

use rand::TryRng as _;
use rand::rngs::SysRng;

use crate::wording::hexadecimal;

/// Maximum length of a request's head \[byte\].
const LONGEST: usize = 16 << 10;

/// Maximum number of headers in a request.
const HEADERS: usize = 64;

/// The head of a request.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Request {
    pub(super) method: String,
    pub(super) path: String,
    headers: Vec<(String, String)>,
}

impl Request {
    /// Reads a head; `None` if the connection ends before it is complete.
    ///
    /// # Errors
    /// The errors of the connection; [`ErrorKind::InvalidData`] if the header is not that of HTTP 1 or is too long.
    pub(super) fn read(from: &mut impl Read) -> io::Result<Option<Self>> {
        let (mut bytes, mut part) = (Vec::new(), [0; 2048]);
        loop {
            let count = from.read(&mut part)?;
            if count == 0 {
                return Ok(None);
            }
            bytes.extend_from_slice(&part[..count]);
            if let Some(request) = Self::parse(&bytes)? {
                return Ok(Some(request));
            }
            if bytes.len() > LONGEST {
                return Err(ErrorKind::InvalidData.into());
            }
        }
    }

    /// Parses the head at the start of the bytes; `None` if it is incomplete.
    fn parse(bytes: &[u8]) -> io::Result<Option<Self>> {
        let mut headers = [httparse::EMPTY_HEADER; HEADERS];
        let mut request = httparse::Request::new(&mut headers);
        let wrong = |error| io::Error::new(ErrorKind::InvalidData, error);
        if request.parse(bytes).map_err(wrong)?.is_partial() {
            return Ok(None);
        }
        let text = |value: &[u8]| String::from_utf8_lossy(value).into_owned();
        let header = |header: &httparse::Header<'_>| (header.name.to_ascii_lowercase(), text(header.value));
        Ok(Some(Self {
            method: request.method.unwrap_or_default().to_owned(),
            path: request.path.unwrap_or_default().to_owned(),
            headers: request.headers.iter().map(header).collect(),
        }))
    }

    /// All values of a header.
    fn header<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a str> {
        let own = self.headers.iter().filter(move |(own, _)| own == name);
        own.map(|(_, value)| value.as_str())
    }

    /// The path after the token, if the server at `address` may respond to the request.
    pub(super) fn admitted(&self, address: SocketAddr, token: &str) -> Option<&str> {
        let mut hosts = self.header("host");
        let host = hosts.next()?;
        // A server on all interfaces responds at each of their addresses. A foreign name is not an address.
        let named: SocketAddr = host.parse().ok()?;
        let same_ip = address.ip().is_unspecified() || named.ip() == address.ip();
        let own_host = same_ip && named.port() == address.port() && hosts.next().is_none();
        let own_origin = self
            .header("origin")
            .all(|origin| origin.strip_prefix("http://") == Some(host));
        // The browser states which site requests the page; `none` means the user.
        let own_site = self
            .header("sec-fetch-site")
            .all(|site| ["same-origin", "none"].contains(&site));
        let (given, rest) = self.path.strip_prefix('/')?.split_once('/')?;
        (own_host && own_origin && own_site && same(given, token)).then_some(rest)
    }
}

/// Whether two texts are equal, in a time that does not reveal how many characters agree.
fn same(given: &str, token: &str) -> bool {
    let differences = given.bytes().zip(token.bytes()).fold(0, |all, (a, b)| all | (a ^ b));
    given.len() == token.len() && differences == 0
}

/// A token that cannot be guessed: 128 bits of the system's random numbers.
///
/// # Errors
/// If the system provides none.
pub(super) fn token() -> io::Result<String> {
    let mut bytes = [0u8; 16];
    SysRng.try_fill_bytes(&mut bytes).map_err(io::Error::other)?;
    Ok(hexadecimal(&bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn admitted_at(address: &str, head: &str) -> Option<String> {
        let request = Request::read(&mut head.as_bytes()).expect("a head").expect("whole");
        let address = address.parse().expect("an address");
        request.admitted(address, "secret").map(str::to_owned)
    }

    fn admitted(head: &str) -> Option<String> {
        admitted_at("127.0.0.1:4711", head)
    }

    /// Every interface has a different address. A name that resolves to one of them is foreign, and so is a page under
    /// it.
    #[test]
    fn a_server_on_all_interfaces_answers_under_addresses_and_not_under_names() {
        let at = |host: &str, more: &str| {
            admitted_at(
                "0.0.0.0:4711",
                &format!("GET /secret/ HTTP/1.1\r\nHost: {host}\r\n{more}\r\n"),
            )
        };
        assert!(
            at("192.168.1.7:4711", "").is_some()
                && at("192.168.1.7:4711", "Origin: http://192.168.1.7:4711\r\n").is_some()
        );
        for (host, more) in [
            ("evil.example:4711", ""),
            ("192.168.1.7:80", ""),
            ("192.168.1.7:4711", "Origin: http://evil.example:4711\r\n"),
            ("192.168.1.7:4711", "Sec-Fetch-Site: cross-site\r\n"),
        ] {
            assert_eq!(at(host, more), None, "{host} {more}");
        }
        assert_eq!(
            admitted_at(
                "192.168.1.7:4711",
                "GET /secret/ HTTP/1.1\r\nHost: 10.0.0.1:4711\r\n\r\n"
            ),
            None
        );
    }

    #[test]
    fn the_users_own_request_is_admitted() {
        let head = "GET /secret/report HTTP/1.1\r\nHost: 127.0.0.1:4711\r\n";
        assert_eq!(admitted(&format!("{head}\r\n")).as_deref(), Some("report"));
        assert!(admitted(&format!("{head}Sec-Fetch-Site: none\r\n\r\n")).is_some());
        assert!(admitted(&format!("{head}Origin: http://127.0.0.1:4711\r\n\r\n")).is_some());
    }

    #[test]
    fn foreign_hosts_origins_and_tokens_are_not() {
        for head in [
            "GET /other/ HTTP/1.1\r\nHost: 127.0.0.1:4711\r\n\r\n",
            "GET /secre/ HTTP/1.1\r\nHost: 127.0.0.1:4711\r\n\r\n",
            "GET /secrets/ HTTP/1.1\r\nHost: 127.0.0.1:4711\r\n\r\n",
            "GET / HTTP/1.1\r\nHost: 127.0.0.1:4711\r\n\r\n",
            "GET /secret HTTP/1.1\r\nHost: 127.0.0.1:4711\r\n\r\n",
            "GET /secret/ HTTP/1.1\r\n\r\n",
            "GET /secret/ HTTP/1.1\r\nHost: evil.example:4711\r\n\r\n",
            "GET /secret/ HTTP/1.1\r\nHost: 127.0.0.1:4711\r\nHost: evil.example\r\n\r\n",
            "GET /secret/ HTTP/1.1\r\nHost: 127.0.0.1:4711\r\nOrigin: http://evil.example\r\n\r\n",
            "GET /secret/ HTTP/1.1\r\nHost: 127.0.0.1:4711\r\nOrigin: null\r\n\r\n",
            "GET /secret/ HTTP/1.1\r\nHost: 127.0.0.1:4711\r\nSec-Fetch-Site: cross-site\r\n\r\n",
            "GET /secret/ HTTP/1.1\r\nHost: 127.0.0.1:4711\r\nSec-Fetch-Site: same-site\r\n\r\n",
        ] {
            assert_eq!(admitted(head), None, "{head}");
        }
    }

    #[test]
    fn what_is_no_head_or_has_no_end_is_refused() {
        assert!(Request::read(&mut &b"\x16\x03\x01 hello\r\n\r\n"[..]).is_err());
        assert!(Request::read(&mut io::repeat(b'a')).is_err());
        assert_eq!(Request::read(&mut &b"GET /secret/ HT"[..]).ok(), Some(None));
    }

    #[test]
    fn no_token_is_given_twice() {
        let (one, other) = (token().expect("numbers"), token().expect("numbers"));
        assert!(one != other && one.len() == 32);
    }
}
