//! The server of the page: on this machine alone, for a handful of windows, without anything of others.
//!
//! It answers each request on a thread and connection of its own, and knows five addresses. Heads are parsed by `httparse`;
//! servers of their own are no better here: `tiny_http` is no longer maintained, `oxhttp` chooses no free port and writes to
//! standard error, `hyper` brings an asynchronous runtime.

use std::io::{self, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use super::board::Board;
use super::page;
use super::request::{Request, token};

/// How long a browser may take to ask or to receive.
const PATIENCE: Duration = Duration::from_secs(20);

/// Between two signs of life to a window that waits for news.
const SIGN: Duration = Duration::from_secs(5);

/// Connections at a time.
const MOST: usize = 64;

/// Every answer: nothing is kept, no other site learns the address, nothing is shown within a foreign page.
const ALWAYS: &str = "Cache-Control: no-store\r\nReferrer-Policy: no-referrer\r\nX-Content-Type-Options: nosniff\r\n\
                      Cross-Origin-Resource-Policy: same-origin\r\nCross-Origin-Opener-Policy: same-origin\r\nConnection: close\r\n";

/// What the page around the report may do: ask this server, and run its own script.
const OUTER: &str = "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; frame-src 'self'; \
                     img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// What the report may do: draw, and ask for nothing.
const INNER: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; \
                     img-src data:; media-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'self'";

/// A server, which ends when it is dropped.
pub struct Server {
    host: SocketAddr,
    token: Arc<str>,
    shared: Arc<Shared>,
    accepting: Option<JoinHandle<()>>,
}

struct Shared {
    board: Arc<Board>,
    ends: AtomicBool,
    open: AtomicUsize,
}

impl Server {
    /// Serves a board on a port of the loopback interface that the system chooses.
    ///
    /// # Errors
    /// Those of the system.
    pub fn start(board: Arc<Board>) -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
        let (host, token) = (listener.local_addr()?, Arc::<str>::from(token()?));
        let shared = Arc::new(Shared {
            board,
            ends: AtomicBool::new(false),
            open: AtomicUsize::new(0),
        });
        let accepting = std::thread::spawn({
            let (shared, token) = (Arc::clone(&shared), Arc::clone(&token));
            move || accept(&listener, &shared, &host.to_string(), &token)
        });
        Ok(Self {
            host,
            token,
            shared,
            accepting: Some(accepting),
        })
    }

    /// Where the page is.
    pub fn address(&self) -> String {
        format!("http://{}/{}/", self.host, self.token)
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.shared.ends.store(true, Ordering::SeqCst);
        self.shared.board.wake();
        // A connection of its own lets it look.
        let _ = TcpStream::connect(self.host);
        if let Some(accepting) = self.accepting.take() {
            let _ = accepting.join();
        }
    }
}

/// Answers connections, each on a thread, until the server ends; the threads have ended then, too.
fn accept(listener: &TcpListener, shared: &Shared, host: &str, token: &str) {
    std::thread::scope(|scope| {
        for stream in listener.incoming() {
            if shared.ends.load(Ordering::SeqCst) {
                return;
            }
            // A connection that has gone before it was accepted, or a moment without file handles.
            let Ok(stream) = stream else {
                std::thread::sleep(Duration::from_millis(10));
                continue;
            };
            if shared.open.fetch_add(1, Ordering::SeqCst) >= MOST {
                shared.open.fetch_sub(1, Ordering::SeqCst);
                continue;
            }
            scope.spawn(move || {
                // A browser that has gone is no error.
                let _ = answer(&stream, shared, host, token);
                shared.open.fetch_sub(1, Ordering::SeqCst);
            });
        }
    });
}

fn answer(mut stream: &TcpStream, shared: &Shared, host: &str, token: &str) -> io::Result<()> {
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let request = match Request::read(&mut stream) {
        Ok(Some(request)) => request,
        Ok(None) => return Ok(()),
        Err(error) if error.kind() == io::ErrorKind::InvalidData => {
            return send(stream, ("400 Bad Request", TEXT, OUTER), b"no request of HTTP 1.1\n");
        }
        Err(error) => return Err(error),
    };
    let Some(path) = request.admitted(host, token) else {
        let refusal = b"refused: open the address that `nailnoise watch` printed\n";
        return send(stream, ("403 Forbidden", TEXT, OUTER), refusal);
    };
    let board = &shared.board;
    match (request.method.as_str(), path) {
        ("GET", "") => send(stream, ("200 OK", HTML, OUTER), page::page(board).as_bytes()),
        ("GET", "watch.js") => send(stream, ("200 OK", SCRIPT, OUTER), page::SCRIPT.as_bytes()),
        ("GET", "watch.css") => send(stream, ("200 OK", STYLE, OUTER), page::STYLE.as_bytes()),
        ("GET", "events") => news(stream, shared),
        ("GET", path) if path == "report" || path.starts_with("report?") => match board.now().report {
            Some((_, report)) => send(stream, ("200 OK", HTML, INNER), report.as_bytes()),
            None => send(stream, ("404 Not Found", TEXT, OUTER), b"there is no result yet\n"),
        },
        ("POST", "pin") | ("POST", "unpin") => {
            board.pin(path == "pin");
            send(stream, ("200 OK", TEXT, OUTER), b"done\n")
        }
        _ => send(stream, ("404 Not Found", TEXT, OUTER), b"there is nothing here\n"),
    }
}

const TEXT: &str = "text/plain; charset=utf-8";
const HTML: &str = "text/html; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
const STYLE: &str = "text/css; charset=utf-8";

fn send(mut stream: &TcpStream, (status, kind, policy): (&str, &str, &str), body: &[u8]) -> io::Result<()> {
    let length = body.len();
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\nContent-Security-Policy: {policy}\r\n{ALWAYS}\r\n"
    );
    stream.write_all(head.as_bytes())?;
    stream.write_all(body)?;
    stream.flush()
}

/// Sends every change to a window until it is closed (server-sent events).
fn news(mut stream: &TcpStream, shared: &Shared) -> io::Result<()> {
    let head = format!("HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\n{ALWAYS}\r\n");
    stream.write_all(head.as_bytes())?;
    let mut told = None;
    while !shared.ends.load(Ordering::SeqCst) {
        let state = match told {
            None => shared.board.now(),
            Some(version) => shared.board.wait(version, SIGN),
        };
        if told == Some(state.version) {
            stream.write_all(b":\n\n")?;
        } else {
            told = Some(state.version);
            let event = page::event(&shared.board.name, &state);
            stream.write_all(format!("data: {event}\n\n").as_bytes())?;
        }
        stream.flush()?;
    }
    Ok(())
}
