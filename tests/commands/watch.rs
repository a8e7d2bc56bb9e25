//! `nailnoise watch`: every save reaches the page, a broken design leaves the last result, and nobody else is served.

use std::fs;
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::common::{ROOT, SMALL, command, folder};

/// How long anything may take on a machine that does other things as well.
const PATIENCE: Duration = Duration::from_secs(300);

/// A separate design that is watched, and the news of its page.
struct Watched {
    design: PathBuf,
    process: Child,
    /// `127.0.0.1:PORT`.
    host: String,
    token: String,
    news: BufReader<TcpStream>,
}

impl Watched {
    fn start(name: &str) -> Self {
        Self::with(name, &[])
    }

    fn with(name: &str, more: &[&str]) -> Self {
        let folder = folder(name);
        let design = folder.join("own.toml");
        fs::write(
            folder.join("between.toml"),
            format!("base = {:?}\n", Path::new(ROOT).join(SMALL)),
        )
        .unwrap();
        fs::write(&design, text("690 kPa")).unwrap();
        let mut process = command(&[&["watch", design.to_str().unwrap()], more].concat())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut address = String::new();
        let mut output = BufReader::new(process.stdout.take().unwrap());
        output.read_line(&mut address).unwrap();
        // Its later output is read, so that it never waits for a reader.
        std::thread::spawn(move || std::io::copy(&mut output, &mut std::io::sink()));
        let address = address.trim().strip_prefix("http://").unwrap();
        let (host, token) = address.trim_end_matches('/').split_once('/').unwrap();
        // All interfaces include the loopback one.
        let (host, token) = (host.replace("0.0.0.0", "127.0.0.1"), token.to_owned());
        let mut stream = TcpStream::connect(&host).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        write!(stream, "GET /{token}/events HTTP/1.1\r\nHost: {host}\r\n\r\n").unwrap();
        let news = BufReader::new(stream);
        Self {
            design,
            process,
            host,
            token,
            news,
        }
    }

    /// The first news that are as they should be.
    #[track_caller]
    fn until(&mut self, what: &str, wanted: impl Fn(&Value) -> bool) -> Value {
        let since = Instant::now();
        let mut last = String::new();
        while since.elapsed() < PATIENCE {
            let mut line = String::new();
            self.news.read_line(&mut line).unwrap();
            let Some(data) = line.strip_prefix("data: ") else {
                continue;
            };
            let news: Value = serde_json::from_str(data).unwrap();
            if wanted(&news) {
                return news;
            }
            last = line;
        }
        panic!("no news of {what}; the last: {last}");
    }

    /// The news of a run that succeeded, whose bar names this value.
    #[track_caller]
    fn shown(&mut self, value: &str) -> Value {
        let end = format!("\u{2192} {value}");
        self.until(value, |news| {
            news["failure"].is_null() && news["bar"].as_str().unwrap().contains(&end)
        })
    }

    /// Status and body of the response to a request with these headers.
    fn ask(&self, method: &str, path: &str, headers: &str) -> (u16, String) {
        let mut stream = TcpStream::connect(&self.host).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        write!(stream, "{method} {path} HTTP/1.1\r\n{headers}\r\n").unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        let (head, body) = answer.split_once("\r\n\r\n").unwrap();
        (head.split(' ').nth(1).unwrap().parse().unwrap(), body.to_owned())
    }

    /// Status of the response to the user's browser, whatever its body.
    fn head(&self, method: &str, path: &str) -> u16 {
        let mut stream = TcpStream::connect(&self.host).unwrap();
        write!(
            stream,
            "{method} /{}/{path} HTTP/1.1\r\nHost: {}\r\n\r\n",
            self.token, self.host
        )
        .unwrap();
        let mut line = String::new();
        BufReader::new(stream).read_line(&mut line).unwrap();
        line.split(' ').nth(1).unwrap().parse().unwrap()
    }

    /// Response to the user's browser.
    fn page(&self, path: &str) -> (u16, String) {
        self.ask(
            "GET",
            &format!("/{}/{path}", self.token),
            &format!("Host: {}\r\n", self.host),
        )
    }
}

impl Drop for Watched {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn text(pressure: &str) -> String {
    format!("base = \"between.toml\"\nsupply.pressure = \"{pressure}\"\n")
}

/// Methods that editors use to save.
const WAYS: [fn(&Path, &str); 4] = [
    |path, text| fs::write(path, text).unwrap(),
    |path, text| {
        let new = path.with_extension("toml.swp");
        fs::write(&new, text).unwrap();
        fs::rename(new, path).unwrap();
    },
    |path, text| {
        fs::remove_file(path).unwrap();
        std::thread::sleep(Duration::from_millis(30));
        fs::write(path, text).unwrap();
    },
    |path, text| {
        let (half, rest) = text.split_at(text.len() / 2);
        let mut file = fs::File::create(path).unwrap();
        file.write_all(half.as_bytes()).unwrap();
        std::thread::sleep(Duration::from_millis(150));
        file.write_all(rest.as_bytes()).unwrap();
    },
];

/// Broken designs, and the words of the page on them.
const BROKEN: [(&str, &str); 4] = [
    ("supply.pressure = \"600 ", "own.toml:1"),
    ("base = \"between.toml\"\nsupply.presure = 1\n", "supply.pressure"),
    ("base = \"between.toml\"\nsupply.pressure = \"3 mm\"\n", "wrong unit"),
    ("base = \"beneath.toml\"\n", "beneath.toml"),
];

#[test]
fn every_save_reaches_the_page_and_what_is_broken_keeps_the_last_result() {
    let mut watched = Watched::start("watch-saves");
    watched.until("the first run", |news| !news["report"].is_null());
    let design = watched.design.clone();
    for (turn, (save, (broken, message))) in WAYS.iter().zip(BROKEN).enumerate() {
        let pressure = format!("70{turn} kPa");
        save(&design, &text(&pressure));
        let news = watched.shown(&pressure);
        assert!(news["title"].as_str().unwrap().contains("dB own"), "{news}");
        let (status, report) = watched.page("report");
        assert!(status == 200 && report.contains("<!DOCTYPE html>"));
        save(&design, broken);
        let failed = |news: &Value| news["failure"].as_str().is_some_and(|text| text.contains(message));
        let news = watched.until(message, failed);
        assert!(
            news["bar"].as_str().unwrap().contains(&format!("\u{2192} {pressure}")),
            "{news}"
        );
        assert!(watched.page("report").1 == report, "the last result stays");
    }
    // Saves that follow each other: the last one counts.
    for turn in 0..10 {
        WAYS[turn % 2](&design, &text(&format!("71{turn} kPa")));
    }
    watched.shown("719 kPa");
    // A base is a file of the design as well.
    let base = design.with_file_name("between.toml");
    let changed = fs::read_to_string(&base).unwrap() + "exhaust.holes = 4\n";
    fs::write(base, changed).unwrap();
    watched.shown("4");
}

#[test]
fn a_pinned_run_is_compared_with() {
    let mut watched = Watched::start("watch-pin");
    watched.until("the first run", |news| {
        !news["report"].is_null() && news["status"].as_str().unwrap().contains("run 1")
    });
    let (host, pin) = (
        format!("Host: {}\r\nContent-Length: 0\r\n", watched.host),
        format!("/{}/pin", watched.token),
    );
    assert_eq!(watched.ask("POST", &pin, &host).0, 200);
    watched.until("the pin", |news| {
        news["bar"].as_str().unwrap().contains("run 1, pinned")
    });
    for pressure in ["700 kPa", "710 kPa"] {
        fs::write(&watched.design, text(pressure)).unwrap();
        watched.shown(pressure);
    }
    let bar = watched.page("").1;
    assert!(
        bar.contains("from run 2") && bar.contains("from run 1, pinned"),
        "{bar}"
    );
    assert!(
        bar.contains("690 kPa \u{2192} 710 kPa") && bar.contains("700 kPa \u{2192} 710 kPa"),
        "{bar}"
    );
}

/// A slider is a value over those of the file until the file is saved; the design is saved under a free name.
#[test]
fn a_slider_runs_the_design_and_saves_it() {
    let mut watched = Watched::start("watch-sliders");
    let news = watched.until("the sliders", |news| {
        news["sliders"].as_array().is_some_and(|own| !own.is_empty())
            && news["status"].as_str().unwrap().contains("run 1")
    });
    let sliders = news["sliders"].as_array().unwrap();
    let slider = sliders.iter().find(|own| own["whole"] == false).unwrap();
    let key = slider["key"].as_str().unwrap();
    let [low, high] = [0, 1].map(|end| slider["range"][end].as_f64().unwrap());
    let post = |watched: &Watched, path: &str| {
        let headers = format!("Host: {}\r\nContent-Length: 0\r\n", watched.host);
        watched.ask("POST", &format!("/{}/{path}", watched.token), &headers).0
    };
    assert_eq!(post(&watched, "pin"), 200);
    let to = low + 0.75 * (high - low);
    for wrong in [
        format!("{key}={}", high + 2.0 * (high - low)),
        "no.key=1".to_owned(),
        format!("{key}=x"),
        key.to_owned(),
    ] {
        assert_eq!(post(&watched, &format!("move?{wrong}")), 400, "{wrong}");
    }
    assert_eq!(post(&watched, &format!("move?{key}={to}")), 200);
    let moved = watched.until("the moved run", |news| {
        news["status"].as_str().unwrap().contains("run 2")
    });
    assert_eq!(moved["moved"], serde_json::json!([key]));
    assert!(
        moved["bar"].as_str().unwrap().contains(&format!("<code>{key}</code>")),
        "{moved}"
    );
    for name in ["last", "pinned"] {
        assert_eq!(watched.head("GET", &format!("sound/{name}")), 200, "{name}");
    }
    assert_eq!(post(&watched, "save"), 200);
    let saved = watched.until("the file", |news| news["saved"].is_string());
    let file = watched.design.with_file_name("own-1.toml");
    assert_eq!(saved["saved"], "saved as own-1.toml");
    let written = fs::read_to_string(&file).unwrap();
    assert!(
        written.contains("base = \"own.toml\"") && written.contains(key),
        "{written}"
    );
    fs::write(&watched.design, text("700 kPa")).unwrap();
    let news = watched.until("the file's run", |news| {
        news["moved"] == serde_json::json!([]) && news["sliders"].as_array().is_some_and(|own| !own.is_empty())
    });
    assert!(news["saved"].is_null());
}

#[test]
fn a_page_for_others_needs_the_token_and_an_address() {
    let watched = Watched::with("watch-listen", &["--listen", "0.0.0.0"]);
    let port = watched.host.split_once(':').unwrap().1;
    let host = format!("Host: 127.0.0.1:{port}\r\n");
    assert_eq!(watched.ask("GET", &format!("/{}/", watched.token), &host).0, 200);
    assert_eq!(watched.ask("GET", "/", &host).0, 403);
    let named = format!("Host: nailnoise.example:{port}\r\n");
    assert_eq!(watched.ask("GET", &format!("/{}/", watched.token), &named).0, 403);
}

/// Each sends a byte now and then, so that no single wait for it is long.
#[test]
fn connections_without_the_token_neither_lock_the_page_out_nor_stay() {
    let watched = Watched::start("watch-strangers");
    let mut strangers: Vec<TcpStream> = (0..200).map(|_| TcpStream::connect(&watched.host).unwrap()).collect();
    let since = Instant::now();
    while since.elapsed() < Duration::from_secs(8) {
        for stranger in &mut strangers {
            let _ = stranger.write_all(b"G");
        }
        let asked = Instant::now();
        assert_eq!(watched.page("").0, 200);
        assert!(asked.elapsed() < Duration::from_secs(5));
        std::thread::sleep(Duration::from_millis(500));
    }
    for stranger in &mut strangers {
        stranger.set_read_timeout(Some(Duration::from_secs(5))).unwrap();
        let ended = stranger.read(&mut [0; 1]);
        let is_open = matches!(&ended, Err(error) if error.kind() == std::io::ErrorKind::WouldBlock);
        assert!(!is_open, "a stranger that never asks has a connection for good");
    }
}

/// As RFC 9110 (9.3.2) has it: the same head, no body.
#[test]
fn head_has_the_head_of_get() {
    let watched = Watched::start("watch-head");
    let own = format!("Host: {}\r\n", watched.host);
    let raw = |method: &str, path: &str| {
        let mut stream = TcpStream::connect(&watched.host).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        write!(stream, "{method} /{}/{path} HTTP/1.1\r\n{own}\r\n", watched.token).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        let (head, body) = answer.split_once("\r\n\r\n").unwrap();
        (head.to_owned(), body.len())
    };
    for path in ["watch.js", "watch.css", "other"] {
        let (get, head) = (raw("GET", path), raw("HEAD", path));
        assert_eq!((&head.0, head.1), (&get.0, 0), "{path}");
        assert!(get.1 > 0 && get.0.contains(&format!("Content-Length: {}", get.1)));
    }
    for path in ["", "events"] {
        let (head, length) = raw("HEAD", path);
        assert!(head.starts_with("HTTP/1.1 200 ") && length == 0, "{path}: {head}");
    }
    let stranger = watched.ask("HEAD", "/other/", &own);
    assert_eq!(stranger, (403, String::new()));
}

#[test]
fn nobody_else_is_answered() {
    let watched = Watched::start("watch-others");
    let (host, token) = (&watched.host, &watched.token);
    let own = format!("Host: {host}\r\n");
    assert_eq!(watched.page("").0, 200);
    assert_eq!(
        watched
            .ask("GET", &format!("/{token}/"), &format!("{own}Origin: http://{host}\r\n"))
            .0,
        200
    );
    let port = host.split_once(':').unwrap().1;
    for path in ["", "report", "events", "watch.js"] {
        let path = format!("/{token}/{path}");
        for headers in [
            String::new(),
            format!("Host: nailnoise.example:{port}\r\n"),
            format!("Host: localhost:{port}\r\n"),
            format!("{own}Origin: http://nailnoise.example\r\n"),
            format!("{own}Origin: null\r\n"),
            format!("{own}Sec-Fetch-Site: cross-site\r\n"),
        ] {
            let (status, body) = watched.ask("GET", &path, &headers);
            assert!(
                status == 403 && !body.contains(token.as_str()),
                "{path} {headers}: {status} {body}"
            );
        }
    }
    let other: String = token.chars().rev().collect();
    for path in [
        "/".to_owned(),
        format!("/{other}/"),
        format!("/{}/", &token[1..]),
        format!("/{other}/events"),
    ] {
        assert_eq!(watched.ask("GET", &path, &own).0, 403, "{path}");
    }
    let foreign = format!("{own}Origin: http://nailnoise.example\r\nContent-Length: 0\r\n");
    assert_eq!(watched.ask("POST", &format!("/{token}/pin"), &foreign).0, 403);
    assert_eq!(watched.page("other").0, 404);
}

#[test]
#[cfg(unix)]
fn an_interruption_ends_command_and_page() {
    let mut watched = Watched::start("watch-end");
    watched.until("the first run", |news| !news["report"].is_null());
    let number = watched.process.id().to_string();
    let sent = std::process::Command::new("kill")
        .args(["-INT", &number])
        .status()
        .unwrap();
    assert!(sent.success());
    assert_eq!(watched.process.wait().unwrap().code(), Some(130));
    assert!(TcpStream::connect(&watched.host).is_err());
}
