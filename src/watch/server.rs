//! Serves the page, on this machine unless the user names an address, to a handful of windows, without third-party
//! content.
//!
//! It responds to each request on a separate thread and connection, and serves a handful of addresses. A client that
//! has not yet shown the token is a stranger. The number and duration of strangers' connections are limited separately
//! from those of windows: if there are too many, the oldest is closed. Heads are parsed by `httparse`.
//!
//! The complete servers that were considered do not give these guarantees. They do not let the caller reach a
//! connection before its request is complete:
//!
//! - `tiny_http` 0.12 sets no time limit for reading or writing, and has no maximum for the length of a head or the
//!   number of connections. A stranger that sends one byte a minute occupies a thread and memory without end, and a
//!   window that no longer reads blocks its writer.
//! - `oxhttp` 0.3 limits the time of each read, not of a complete head. It cannot report a port chosen by the system,
//!   has no way to stop, writes to standard error, and depends on more than 30 crates for URLs with international
//!   names.
//! - `hyper` requires an asynchronous runtime.
//!
//! They would replace the parsing of heads, most of which `httparse` does, and the writing of responses: about 70 lines
//! of this folder. The code for addresses, limits, permissions and events would remain.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

use super::board::Board;
use super::page;
use super::request::{Request, token};

/// Maximum time for receiving the head of a request.
const TO_ASK: Duration = Duration::from_secs(5);

/// Maximum time for a browser to receive a response or an event.
const TO_RECEIVE: Duration = Duration::from_secs(20);

/// Interval of the signals that keep the connection to a waiting window open.
const SIGN: Duration = Duration::from_secs(5);

/// Maximum number of simultaneous connections with the token.
const WINDOWS: usize = 64;

/// Maximum number of simultaneous connections whose token is not yet known.
const STRANGERS: usize = 64;

/// Headers of every response: nothing is cached, no other site learns the address, and no foreign page may embed the
/// content.
const ALWAYS: &str = "Cache-Control: no-store\r\nReferrer-Policy: no-referrer\r\nX-Content-Type-Options: nosniff\r\n\
                      Cross-Origin-Resource-Policy: same-origin\r\nCross-Origin-Opener-Policy: \
                      same-origin\r\nConnection: close\r\n";

/// Permissions of the page around the report: contact this server and run its script.
const OUTER: &str = "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; frame-src 'self'; \
                     img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Permissions of the report: draw, but request nothing.
const INNER: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; \
                     img-src data:; media-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'self'";

/// A server that ends when it is dropped.
pub struct Server {
    host: SocketAddr,
    token: Arc<str>,
    shared: Arc<Shared>,
    accepting: Option<JoinHandle<()>>,
}

struct Shared {
    board: Arc<Board>,
    ends: AtomicBool,
    /// Connections with the token.
    windows: AtomicUsize,
    /// The other connections, oldest first.
    strangers: Mutex<Vec<Arc<TcpStream>>>,
}

impl Shared {
    /// Counts a new connection; if there are too many, the oldest stranger's is closed.
    fn receive(&self, stream: &Arc<TcpStream>) {
        let mut strangers = self.strangers.lock().unwrap_or_else(PoisonError::into_inner);
        strangers.push(Arc::clone(stream));
        if strangers.len() > STRANGERS {
            // Its thread detects that the connection is closed.
            let _ = strangers.remove(0).shutdown(Shutdown::Both);
        }
    }

    /// Stops counting a connection as a stranger's.
    fn dismiss(&self, stream: &Arc<TcpStream>) {
        let mut strangers = self.strangers.lock().unwrap_or_else(PoisonError::into_inner);
        strangers.retain(|own| !Arc::ptr_eq(own, stream));
    }
}

/// A connection with a time limit for the complete operation, however many pieces it consists of.
struct Timed<'a> {
    stream: &'a TcpStream,
    until: Instant,
}

impl<'a> Timed<'a> {
    fn new(stream: &'a TcpStream, time: Duration) -> Self {
        let until = Instant::now() + time;
        Self { stream, until }
    }

    fn left(&self) -> io::Result<Option<Duration>> {
        let left = self.until.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(ErrorKind::TimedOut.into());
        }
        Ok(Some(left))
    }
}

impl Read for Timed<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        self.stream.set_read_timeout(self.left()?)?;
        self.stream.read(bytes)
    }
}

impl Write for Timed<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.stream.set_write_timeout(self.left()?)?;
        self.stream.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.stream.flush()
    }
}

impl Server {
    /// Serves a board at an address, or on the loopback interface only. The system chooses a port that is 0.
    ///
    /// # Errors
    /// The errors of the system.
    pub fn start(board: Arc<Board>, listen: Option<SocketAddr>) -> io::Result<Self> {
        let listener = TcpListener::bind(listen.unwrap_or_else(|| (Ipv4Addr::LOCALHOST, 0).into()))?;
        let (host, token) = (listener.local_addr()?, Arc::<str>::from(token()?));
        let shared = Arc::new(Shared {
            board,
            ends: AtomicBool::new(false),
            windows: AtomicUsize::new(0),
            strangers: Mutex::default(),
        });
        let accepting = Builder::new().spawn({
            let (shared, token) = (Arc::clone(&shared), Arc::clone(&token));
            move || accept(&listener, &shared, host, &token)
        })?;
        Ok(Self {
            host,
            token,
            shared,
            accepting: Some(accepting),
        })
    }

    /// Address of the page.
    pub fn address(&self) -> String {
        format!("http://{}/{}/", self.host, self.token)
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.shared.ends.store(true, Ordering::SeqCst);
        self.shared.board.wake();
        let strangers = std::mem::take(&mut *self.shared.strangers.lock().unwrap_or_else(PoisonError::into_inner));
        for stranger in strangers {
            let _ = stranger.shutdown(Shutdown::Both);
        }
        // A connection to the server's address makes it check; all interfaces include the loopback one.
        let mut own = self.host;
        if own.ip().is_unspecified() {
            own.set_ip(Ipv4Addr::LOCALHOST.into());
        }
        let _ = TcpStream::connect(own);
        if let Some(accepting) = self.accepting.take() {
            let _ = accepting.join();
        }
    }
}

/// Answers each connection on a thread until the server ends; all threads have ended when it returns.
fn accept(listener: &TcpListener, shared: &Shared, host: SocketAddr, token: &str) {
    std::thread::scope(|scope| {
        for stream in listener.incoming() {
            if shared.ends.load(Ordering::SeqCst) {
                return;
            }
            // The client disconnected before it was accepted, or file handles ran out temporarily.
            let Ok(stream) = stream else {
                std::thread::sleep(Duration::from_millis(10));
                continue;
            };
            let stream = Arc::new(stream);
            shared.receive(&stream);
            let own = Arc::clone(&stream);
            let answering = Builder::new().spawn_scoped(scope, move || {
                // It is not an error if the browser has disconnected.
                let _ = answer(&own, shared, host, token);
                shared.dismiss(&own);
                let _ = own.shutdown(Shutdown::Both);
            });
            if answering.is_err() {
                // The system permits no more threads for now.
                shared.dismiss(&stream);
            }
        }
    });
}

fn answer(stream: &Arc<TcpStream>, shared: &Shared, host: SocketAddr, token: &str) -> io::Result<()> {
    let request = match Request::read(&mut Timed::new(stream, TO_ASK)) {
        Ok(Some(request)) => request,
        Ok(None) => return Ok(()),
        Err(error) if error.kind() == ErrorKind::InvalidData => {
            let reply = Reply::text("400 Bad Request", b"no request of HTTP 1.1\n");
            return reply.send(stream, false);
        }
        Err(error) => return Err(error),
    };
    let head_alone = request.method == "HEAD";
    let Some(path) = request.admitted(host, token) else {
        let reply = Reply::text(
            "403 Forbidden",
            b"refused: open the address that `nailnoise watch` printed\n",
        );
        return reply.send(stream, head_alone);
    };
    shared.dismiss(stream);
    let answered = if shared.windows.fetch_add(1, Ordering::SeqCst) < WINDOWS {
        admitted(stream, shared, (&request.method, path))
    } else {
        let reply = Reply::text(
            "503 Service Unavailable",
            b"too many windows are open: close some of them\n",
        );
        reply.send(stream, head_alone)
    };
    shared.windows.fetch_sub(1, Ordering::SeqCst);
    answered
}

/// Answers a request with the token. HEAD returns the head of the response to GET.
fn admitted(stream: &TcpStream, shared: &Shared, (method, path): (&str, &str)) -> io::Result<()> {
    let board = &shared.board;
    let head_alone = method == "HEAD";
    let method = if head_alone { "GET" } else { method };
    let reply = |kind, policy, body| Reply {
        status: "200 OK",
        kind,
        policy,
        body,
    };
    match (method, path) {
        ("GET", "") => reply(HTML, OUTER, page::page(board).as_bytes()).send(stream, head_alone),
        ("GET", "watch.js") => reply(SCRIPT, OUTER, page::SCRIPT.as_bytes()).send(stream, head_alone),
        ("GET", "watch.css") => reply(STYLE, OUTER, page::STYLE.as_bytes()).send(stream, head_alone),
        ("GET", "events") => news(stream, shared, head_alone),
        ("GET", path) if path == "report" || path.starts_with("report?") => match board.now().report {
            Some((_, report)) => reply(HTML, INNER, report.as_bytes()).send(stream, head_alone),
            None => Reply::text("404 Not Found", b"there is no result yet\n").send(stream, head_alone),
        },
        ("GET", "sound/last" | "sound/pinned") => {
            let state = board.now();
            let run = if path == "sound/last" { state.last } else { state.pinned };
            match run.and_then(|run| run.sound.clone()) {
                Some(sound) => reply(WAVE, OUTER, &sound.wav).send(stream, head_alone),
                None => Reply::text("404 Not Found", b"that run has no sound\n").send(stream, head_alone),
            }
        }
        ("POST", "pin" | "unpin" | "reset" | "save") => {
            match path {
                "reset" => board.reset(),
                "save" => board.save(),
                _ => board.pin(path == "pin"),
            }
            reply(TEXT, OUTER, b"done\n").send(stream, false)
        }
        ("POST", path) if path.starts_with("move?") => {
            match moved(path).is_some_and(|(key, to)| board.move_to(key, to)) {
                true => reply(TEXT, OUTER, b"done\n").send(stream, false),
                false => Reply::text("400 Bad Request", b"no slider has this value\n").send(stream, false),
            }
        }
        _ => Reply::text("404 Not Found", b"there is nothing here\n").send(stream, head_alone),
    }
}

/// Key and value of `move?KEY=VALUE`.
fn moved(path: &str) -> Option<(&str, f64)> {
    let (key, value) = path.strip_prefix("move?")?.split_once('=')?;
    Some((key, value.parse().ok()?))
}

const WAVE: &str = "audio/wav";
const TEXT: &str = "text/plain; charset=utf-8";
const HTML: &str = "text/html; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
const STYLE: &str = "text/css; charset=utf-8";

/// A complete response.
struct Reply<'a> {
    status: &'static str,
    /// Its media type.
    kind: &'static str,
    /// Its content security policy.
    policy: &'static str,
    body: &'a [u8],
}

impl<'a> Reply<'a> {
    /// A message.
    fn text(status: &'static str, body: &'a [u8]) -> Self {
        Self {
            status,
            kind: TEXT,
            policy: OUTER,
            body,
        }
    }

    fn send(&self, stream: &TcpStream, head_alone: bool) -> io::Result<()> {
        let mut stream = Timed::new(stream, TO_RECEIVE);
        let Self {
            status,
            kind,
            policy,
            body,
        } = self;
        let length = body.len();
        let head = format!(
            "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\nContent-Security-Policy: \
             {policy}\r\n{ALWAYS}\r\n"
        );
        stream.write_all(head.as_bytes())?;
        if !head_alone {
            stream.write_all(body)?;
        }
        stream.flush()
    }
}

/// Sends every change to a window until it is closed (server-sent events).
fn news(stream: &TcpStream, shared: &Shared, head_alone: bool) -> io::Result<()> {
    let send = |text: &str| Timed::new(stream, TO_RECEIVE).write_all(text.as_bytes());
    send(&format!(
        "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\n{ALWAYS}\r\n"
    ))?;
    let mut told = None;
    while !head_alone && !shared.ends.load(Ordering::SeqCst) {
        let state = match told {
            None => shared.board.now(),
            Some(version) => shared.board.wait(version, SIGN),
        };
        if told == Some(state.version) {
            send(":\n\n")?;
        } else {
            told = Some(state.version);
            let event = page::event(&shared.board.name, &state);
            send(&format!("data: {event}\n\n"))?;
        }
    }
    Ok(())
}
