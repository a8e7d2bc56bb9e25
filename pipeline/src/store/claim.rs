//! Claims show processes that share a folder which of them computes an entry, so that no entry is computed twice at the
//! same time.
//!
//! A claim is a file next to the entry. It is created only if none exists (O_EXCL, which network file systems honour as
//! well) and removed once the entry is written. There are no locks: the owner updates the time of the file every
//! [`BEAT`]. A claim whose time has not changed for [`Patience::stale`] is taken over. The waiting process measures
//! this with its own clock, because the clocks of machines differ. A claim is taken over at once if its owner was a
//! process of this machine that has ended. Even a claim that cannot be read has a time. Every wait is limited: it ends
//! with a stated cause if the object is not a file, cannot be removed, or has an owner that never finishes.
//!
//! Claims are advisory. Entries are written atomically and verified whoever wrote them, so simultaneous owners only
//! waste time.

use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind, Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant, SystemTime};

use thiserror::Error;

/// How often the owner signals that it is alive.
const BEAT: Duration = Duration::from_secs(2);
/// First and longest pause between checks while waiting.
const PAUSES: [Duration; 2] = [Duration::from_millis(5), Duration::from_millis(250)];
/// Largest number of bytes read from a claim file; a claim has less than 200.
const LONGEST_TOKEN: u64 = 4096;

/// Number of claims made by this process.
static TAKEN: AtomicU64 = AtomicU64::new(0);

/// Time limits of a wait for another process.
#[derive(Debug, Clone, Copy)]
pub(super) struct Patience {
    /// A wait longer than this is reported.
    reported: Duration,
    /// An owner whose claim has not changed for this long is assumed dead.
    stale: Duration,
    /// After this time, the entry is computed regardless of other processes.
    longest: Duration,
}

impl Patience {
    /// Network file systems may show times that are a minute old. No stage takes an hour.
    pub(super) const USUAL: Self = Self {
        reported: Duration::from_secs(10),
        stale: Duration::from_secs(90),
        longest: Duration::from_secs(3600),
    };
}

/// Why an entry is computed without a claim.
#[derive(Debug, Error)]
pub(super) enum Unclaimed {
    /// The claim file cannot be created.
    #[error("{} cannot be created ({source})", path.display())]
    NotCreated {
        /// The claim file or the folder.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The path of the claim is occupied by an object that no process of this program creates.
    #[error("{} is {kind}, not the claim of a process; remove it", path.display())]
    Obstacle {
        /// The claim.
        path: PathBuf,
        /// Kind of the object.
        kind: &'static str,
    },
    /// The claim of an ended process cannot be removed.
    #[error("{owner} has ended or been silent too long, and its claim {} cannot be removed ({source})", path.display())]
    Immovable {
        /// The claim.
        path: PathBuf,
        /// The process that made it.
        owner: String,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The owner is alive but does not finish.
    #[error("{owner} has the claim {} and has not finished in {} minutes", path.display(), waited.as_secs() / 60)]
    TooLong {
        /// The claim.
        path: PathBuf,
        /// The process that owns it.
        owner: String,
        /// Time waited so far.
        waited: Duration,
    },
}

/// The claim to compute an entry, released when dropped.
#[derive(Debug)]
pub struct Claim {
    path: PathBuf,
    token: String,
    beat: Option<(Sender<()>, JoinHandle<()>)>,
}

/// Path of the claim file next to an entry; its name lets old claims be swept as temporary files.
fn beside(entry: &Path) -> PathBuf {
    let mut name = std::ffi::OsString::from(".");
    name.push(entry.file_name().unwrap_or_default());
    name.push(".claim.tmp");
    entry.with_file_name(name)
}

/// Waits until no other process has a claim on the entry, and makes one; none if the entry has appeared meanwhile.
/// While waiting, it calls `step` now and then, and `report` once, with the cause, if the wait is long.
///
/// # Errors
/// [`Unclaimed`]: the entry must then be computed without a claim.
pub(super) fn wait(
    entry: &Path,
    patience: Patience,
    appeared: impl Fn() -> bool,
    step: impl Fn(),
    report: impl Fn(String),
) -> Result<Option<Claim>, Unclaimed> {
    let path = beside(entry);
    let (begin, mut pause, mut reported) = (Instant::now(), PAUSES[0], false);
    let mut last: Option<(Seen, Instant)> = None;
    loop {
        match Claim::create(&path) {
            Ok(claim) => return Ok(Some(claim)),
            Err(NotMade::Taken) => {}
            Err(NotMade::Failed(path, source)) => return Err(Unclaimed::NotCreated { path, source }),
        }
        if appeared() {
            return Ok(None);
        }
        // If the claim is gone, the next iteration makes one.
        let owner = if let Some(now) = Seen::look(&path)? {
            let since = last.take().filter(|(seen, _)| *seen == now);
            let since = since.map_or_else(Instant::now, |(_, since)| since);
            if since.elapsed() > patience.stale || now.owner_has_ended() {
                take_over(&path, &now).map_err(|source| Unclaimed::Immovable {
                    path: path.clone(),
                    owner: now.owner(),
                    source,
                })?;
            }
            let owner = now.owner();
            last = Some((now, since));
            owner
        } else {
            "another process".to_owned()
        };
        let waited = begin.elapsed();
        if waited > patience.longest {
            return Err(Unclaimed::TooLong { path, owner, waited });
        }
        if waited > patience.reported && !reported {
            reported = true;
            report(format!(
                "waiting for {owner}, which computes the same (claim {}); the wait ends with its result, {} s after \
                 its last \
                 sign of life, or after {} minutes",
                path.display(),
                patience.stale.as_secs(),
                patience.longest.as_secs() / 60
            ));
        }
        step();
        thread::sleep(pause);
        pause = PAUSES[1].min(2 * pause);
    }
}

/// The content of a claim file.
#[derive(Debug, PartialEq, Eq)]
enum Token {
    Text(String),
    /// Another user may have made a claim that only they can read; its time is still visible.
    Unreadable(ErrorKind),
}

/// A claim as others see it.
#[derive(Debug, PartialEq, Eq)]
struct Seen {
    token: Token,
    time: SystemTime,
}

impl Seen {
    /// Reads the visible state of the claim; none if it is gone. It is reopened each time, which forces a network file
    /// system to ask its server.
    ///
    /// # Errors
    /// [`Unclaimed::Obstacle`] for anything but a file: no process of this program creates or removes such an object.
    fn look(path: &Path) -> Result<Option<Self>, Unclaimed> {
        // Only regular files are opened: opening a pipe would block until it has a writer.
        match fs::symlink_metadata(path) {
            Ok(data) if data.is_file() => {}
            Ok(data) => {
                let kind = match data.file_type() {
                    kind if kind.is_dir() => "a folder",
                    kind if kind.is_symlink() => "a link",
                    _ => "a pipe or a device",
                };
                let path = path.to_owned();
                return Err(Unclaimed::Obstacle { path, kind });
            }
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            Err(source) => {
                let path = path.to_owned();
                return Err(Unclaimed::NotCreated { path, source });
            }
        }
        let token = File::open(path).and_then(|file| {
            let mut bytes = Vec::new();
            file.take(LONGEST_TOKEN).read_to_end(&mut bytes)?;
            Ok(String::from_utf8_lossy(&bytes).into_owned())
        });
        let token = match token {
            Ok(text) => Token::Text(text),
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            Err(error) => Token::Unreadable(error.kind()),
        };
        let time = fs::symlink_metadata(path).and_then(|data| data.modified());
        Ok(time.ok().map(|time| Self { token, time }))
    }

    /// Whether the claim contains this token.
    fn has(&self, token: &str) -> bool {
        matches!(&self.token, Token::Text(own) if own == token)
    }

    /// Machine, process number and start time of the owner; none if the token does not state them.
    fn process(&self) -> Option<(&str, u32, &str)> {
        let Token::Text(text) = &self.token else { return None };
        let mut parts = text.split_whitespace();
        Some((parts.next()?, parts.next()?.parse().ok()?, parts.next()?))
    }

    /// Whether the owner was a process of this machine that no longer runs. A token that is not yet written proves
    /// nothing.
    fn owner_has_ended(&self) -> bool {
        self.process().is_some_and(|(machine, process, started)| {
            this_machine().is_some_and(|own| own == machine) && start_of(process).as_deref() != Some(started)
        })
    }

    /// Describes the owner for messages.
    fn owner(&self) -> String {
        match (self.process(), &self.token) {
            (Some((machine, process, _)), _) if this_machine().is_some_and(|own| own == machine) => {
                format!("process {process}")
            }
            (Some((_, process, _)), _) => format!("process {process} of another machine"),
            (None, Token::Unreadable(cause)) => format!("a process whose claim cannot be read ({cause})"),
            (None, Token::Text(_)) => "a process that its claim does not name".to_owned(),
        }
    }
}

/// Removes a claim without an owner. If several processes try, only one succeeds in renaming it; a claim that was taken
/// over meanwhile is restored.
///
/// # Errors
/// If the claim cannot be renamed, for example in a folder where only owners may rename files.
fn take_over(path: &Path, stale: &Seen) -> io::Result<()> {
    let mut aside = path.as_os_str().to_owned();
    aside.push(format!(
        ".{}-{}.tmp",
        std::process::id(),
        TAKEN.fetch_add(1, Ordering::Relaxed)
    ));
    let aside = PathBuf::from(aside);
    match fs::rename(path, &aside) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
        renamed => renamed?,
    }
    let is_another = matches!(Seen::look(&aside), Ok(Some(found)) if found.token != stale.token);
    if is_another {
        fs::rename(&aside, path)
    } else {
        fs::remove_file(&aside)
    }
}

/// Identifies the machine since its start, and its namespace of process numbers; none if the system does not report it.
fn this_machine() -> Option<String> {
    let boot = fs::read_to_string("/proc/sys/kernel/random/boot_id").ok()?;
    let space = fs::read_link("/proc/self/ns/pid").ok()?;
    Some(format!("{}/{}", boot.trim(), space.display()))
}

/// Start time of a process of this machine, in clock ticks; none if it does not run.
fn start_of(process: u32) -> Option<String> {
    let text = fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // The command name, in brackets, may contain spaces; the start time is the 20th field after it.
    Some(text.rsplit_once(')')?.1.split_whitespace().nth(19)?.to_owned())
}

/// Why a claim could not be made.
#[derive(Debug)]
enum NotMade {
    /// Another claim exists.
    Taken,
    /// This file or folder cannot be created.
    Failed(PathBuf, io::Error),
}

impl Claim {
    /// Creates the file unless it exists.
    fn create(path: &Path) -> Result<Self, NotMade> {
        // If the folder's path is a file, the system reports the same error as for an existing claim.
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).map_err(|source| NotMade::Failed(folder.to_owned(), source))?;
        }
        let file = OpenOptions::new().write(true).create_new(true).open(path);
        let mut file = file.map_err(|error| match error.kind() {
            ErrorKind::AlreadyExists => NotMade::Taken,
            _ => NotMade::Failed(path.to_owned(), error),
        })?;
        let process = std::process::id();
        let token = format!(
            "{} {process} {} {}\n",
            this_machine().unwrap_or_else(|| "unknown".to_owned()),
            start_of(process).unwrap_or_else(|| "0".to_owned()),
            TAKEN.fetch_add(1, Ordering::Relaxed)
        );
        if let Err(error) = file.write_all(token.as_bytes()) {
            let _ = fs::remove_file(path);
            return Err(NotMade::Failed(path.to_owned(), error));
        }
        Ok(Self {
            path: path.to_owned(),
            token,
            beat: beating(file),
        })
    }
}

/// Spawns a thread that updates the time of the claim file until told to stop. The file stays open, so that a new
/// owner's file at the same path is not touched.
fn beating(file: File) -> Option<(Sender<()>, JoinHandle<()>)> {
    let (sender, ended) = channel();
    let beat = move || {
        while ended.recv_timeout(BEAT) == Err(RecvTimeoutError::Timeout) {
            let _ = file.set_modified(SystemTime::now());
        }
    };
    let thread = thread::Builder::new().name("claim".to_owned()).spawn(beat).ok()?;
    Some((sender, thread))
}

impl Drop for Claim {
    fn drop(&mut self) {
        if let Some((sender, thread)) = self.beat.take() {
            drop(sender);
            let _ = thread.join();
        }
        if matches!(Seen::look(&self.path), Ok(Some(found)) if found.has(&self.token)) {
            let _ = fs::remove_file(&self.path);
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    fn entry(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("nailnoise-claim-{}-{name}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        folder.join("stage-00.entry")
    }

    /// Makes a claim with the usual limits, without reporting.
    fn claimed(entry: &Path) -> Option<Claim> {
        wait(entry, Patience::USUAL, || false, || (), |_| ()).unwrap()
    }

    const SHORT: Patience = Patience {
        reported: Duration::from_millis(10),
        stale: Duration::from_millis(400),
        longest: Duration::from_millis(1500),
    };

    #[test]
    fn a_claim_is_one_owners_and_goes_with_it() {
        let entry = entry("one");
        let claim = claimed(&entry).unwrap();
        assert!(matches!(Claim::create(&beside(&entry)), Err(NotMade::Taken)));
        drop(claim);
        assert_eq!(fs::read_dir(entry.parent().unwrap()).unwrap().count(), 0);
        fs::remove_dir_all(entry.parent().unwrap()).unwrap();
    }

    #[test]
    fn one_who_waits_ends_when_the_entry_appears() {
        let entry = entry("appears");
        let _claim = claimed(&entry).unwrap();
        let steps = std::cell::Cell::new(0);
        let step = || steps.set(steps.get() + 1);
        let other = wait(&entry, Patience::USUAL, || steps.get() == 3, step, |_| ()).unwrap();
        assert!(other.is_none() && steps.get() == 3);
        fs::remove_dir_all(entry.parent().unwrap()).unwrap();
    }

    /// Process 1 of a machine never ends while the machine runs; a different start time shows that its number was
    /// reused.
    #[test]
    #[cfg(target_os = "linux")]
    fn the_claim_of_a_process_that_has_ended_is_taken_over_at_once_and_that_of_another_machine_is_not() {
        let entry = entry("ended");
        let path = beside(&entry);
        let own = std::process::id();
        fs::write(&path, format!("{} {own} 1 0\n", this_machine().unwrap())).unwrap();
        let begin = Instant::now();
        let claim = claimed(&entry).unwrap();
        assert!(begin.elapsed() < Patience::USUAL.stale / 4);
        drop(claim);
        fs::write(&path, format!("elsewhere {own} 1 0\n")).unwrap();
        let steps = std::cell::Cell::new(0);
        let step = || steps.set(steps.get() + 1);
        let other = wait(&entry, Patience::USUAL, || steps.get() > 4, step, |_| ()).unwrap();
        assert!(other.is_none(), "the claim of another machine was taken over at once");
        fs::remove_dir_all(entry.parent().unwrap()).unwrap();
    }

    #[test]
    fn what_another_one_took_over_is_left_alone() {
        let entry = entry("other");
        let claim = claimed(&entry).unwrap();
        fs::write(beside(&entry), "elsewhere 1 1 0\n").unwrap();
        drop(claim);
        assert!(beside(&entry).exists());
        let stale = Seen {
            token: Token::Text("gone".to_owned()),
            time: SystemTime::UNIX_EPOCH,
        };
        take_over(&beside(&entry), &stale).unwrap();
        assert!(beside(&entry).exists(), "a claim that is not the stale one is put back");
        fs::remove_dir_all(entry.parent().unwrap()).unwrap();
    }

    /// Empty, binary, half-written and overlong: each is a file that is not renewed.
    #[test]
    fn a_claim_without_a_legible_owner_is_taken_over_when_it_is_stale_and_the_wait_is_reported() {
        let entry = entry("illegible");
        for content in [
            &b""[..],
            b"\xff\xfe\x00",
            b"machine",
            &[b'a'; 100_000],
            b"machine nobody 1 0\n",
        ] {
            fs::write(beside(&entry), content).unwrap();
            let reports = std::cell::RefCell::new(Vec::new());
            let claim = wait(&entry, SHORT, || false, || (), |text| reports.borrow_mut().push(text));
            assert!(claim.unwrap().is_some());
            let reports = reports.into_inner();
            assert!(
                reports.len() == 1 && reports[0].contains("does not name"),
                "{reports:?}"
            );
        }
        fs::remove_dir_all(entry.parent().unwrap()).unwrap();
    }

    #[test]
    #[cfg(unix)]
    fn what_is_no_file_in_place_of_a_claim_ends_the_wait_at_once_with_its_kind() {
        use std::os::unix::fs::symlink;
        let entry = entry("obstacles");
        let path = beside(&entry);
        let own = path.file_name().unwrap().to_owned();
        let fifo = |path: &Path| {
            assert!(
                std::process::Command::new("mkfifo")
                    .arg(path)
                    .status()
                    .unwrap()
                    .success()
            )
        };
        let kinds: [(&str, &dyn Fn()); 5] = [
            ("a folder", &|| fs::create_dir(&path).unwrap()),
            ("a link", &|| symlink("/nope/nothing", &path).unwrap()),
            ("a link", &|| symlink(&own, &path).unwrap()),
            ("a link", &|| symlink("/dev/zero", &path).unwrap()),
            ("a pipe or a device", &|| fifo(&path)),
        ];
        for (kind, make) in kinds {
            make();
            let begin = Instant::now();
            let found = wait(&entry, Patience::USUAL, || false, || (), |_| ());
            assert!(
                matches!(&found, Err(Unclaimed::Obstacle { kind: own, .. }) if *own == kind),
                "{kind}: {found:?}"
            );
            assert!(begin.elapsed() < Duration::from_secs(5));
            let _ = fs::remove_dir(&path).or_else(|_| fs::remove_file(&path));
        }
        fs::remove_dir_all(entry.parent().unwrap()).unwrap();
    }

    /// A file, and below a file: the system reports `AlreadyExists` for the first, the same as for a claim.
    #[test]
    fn a_folder_that_cannot_be_is_no_claim_of_another_process() {
        let entry = entry("no-folder");
        fs::write(&entry, "a file").unwrap();
        for folder in [entry.clone(), entry.join("below")] {
            let found = wait(&folder.join("stage-00.entry"), Patience::USUAL, || false, || (), |_| ());
            assert!(
                matches!(&found, Err(Unclaimed::NotCreated { path, .. }) if *path == folder),
                "{found:?}"
            );
        }
        fs::remove_dir_all(entry.parent().unwrap()).unwrap();
    }

    /// Its time changes at every check, like that of a process that computes forever.
    #[test]
    fn an_owner_that_lives_and_never_finishes_is_not_waited_for_without_limit() {
        let entry = entry("endless");
        let path = beside(&entry);
        fs::write(&path, "elsewhere 1 1 0\n").unwrap();
        let renew = || {
            let file = File::options().write(true).open(&path).unwrap();
            file.set_modified(SystemTime::now()).unwrap();
        };
        let found = wait(&entry, SHORT, || false, renew, |_| ());
        assert!(
            matches!(&found, Err(Unclaimed::TooLong { owner, .. }) if owner == "process 1 of another machine"),
            "{found:?}"
        );
        assert!(path.exists(), "the claim of a living process is left");
        fs::remove_dir_all(entry.parent().unwrap()).unwrap();
    }
}
