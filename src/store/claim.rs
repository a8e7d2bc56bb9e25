//! Claims: which process computes an entry, so that those that share a folder do not compute the same one side by side.
//!
//! A claim is a file beside the entry. It is created only where there is none (O_EXCL, which network file systems honour, too) and
//! removed once the entry is written. Nothing is locked: the owner sets the time of the file every [`BEAT`], and a claim whose time
//! has stood still for [`STALE`] is taken over, by the clock of the one who waits, because clocks of machines differ. A claim whose
//! owner is a process of this machine that has ended is taken over at once.
//!
//! A claim is advice. Entries are written whole and verified whoever wrote them, so that two owners at once cost time alone.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant, SystemTime};

/// How often the owner shows that it lives.
const BEAT: Duration = Duration::from_secs(2);
/// After which a claim that has not moved is nobody's. Network file systems may show times that are a minute old.
const STALE: Duration = Duration::from_secs(90);
/// First and longest pause of one who waits.
const PAUSES: [Duration; 2] = [Duration::from_millis(5), Duration::from_millis(250)];

/// Claims of this process so far.
static TAKEN: AtomicU64 = AtomicU64::new(0);

/// The claim to compute an entry, given back when it is dropped.
#[derive(Debug)]
pub struct Claim {
    path: PathBuf,
    token: String,
    beat: Option<(Sender<()>, JoinHandle<()>)>,
}

/// The claim's file beside an entry; the name is that of a file which is swept away when it is old.
fn beside(entry: &Path) -> PathBuf {
    let mut name = std::ffi::OsString::from(".");
    name.push(entry.file_name().unwrap_or_default());
    name.push(".claim.tmp");
    entry.with_file_name(name)
}

/// The claim on an entry, once nobody else has it; none where the entry came to be meanwhile, or where no claim can be made.
/// `step` is called now and then while another one has it.
pub(super) fn wait(entry: &Path, appeared: impl Fn() -> bool, step: impl Fn()) -> Option<Claim> {
    let path = beside(entry);
    let (mut seen, mut since, mut pause): (Option<Seen>, Instant, Duration) = (None, Instant::now(), PAUSES[0]);
    loop {
        match Claim::create(&path) {
            Ok(claim) => return Some(claim),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            // A folder that cannot be written, a full disk: the entry is computed without a claim.
            Err(_) => return None,
        }
        let now = Seen::read(&path);
        if now != seen {
            (seen, since) = (now, Instant::now());
        }
        if let Some(other) = &seen
            && (since.elapsed() > STALE || other.owner_has_ended())
        {
            take_over(&path, other);
            continue;
        }
        if appeared() {
            return None;
        }
        step();
        thread::sleep(pause);
        pause = PAUSES[1].min(2 * pause);
    }
}

/// A claim as others see it.
#[derive(Debug, PartialEq, Eq)]
struct Seen {
    token: String,
    time: SystemTime,
}

impl Seen {
    /// What the file says; none where it has gone. It is opened each time, which makes a network file system ask its server.
    fn read(path: &Path) -> Option<Self> {
        let mut file = File::open(path).ok()?;
        let time = file.metadata().and_then(|data| data.modified()).ok()?;
        let mut token = String::new();
        file.read_to_string(&mut token).ok()?;
        Some(Self { token, time })
    }

    /// Whether the owner was a process of this machine that no longer runs. A token that is not yet written says nothing.
    fn owner_has_ended(&self) -> bool {
        let mut parts = self.token.split_whitespace();
        let (Some(machine), Some(process), Some(started)) = (parts.next(), parts.next(), parts.next()) else {
            return false;
        };
        this_machine().is_some_and(|own| own == machine)
            && process
                .parse()
                .is_ok_and(|process| start_of(process).as_deref() != Some(started))
    }
}

/// Removes a claim that is nobody's. Of several who try, one renames it; a claim that was taken over meanwhile is put back.
fn take_over(path: &Path, stale: &Seen) {
    let mut aside = path.as_os_str().to_owned();
    aside.push(format!(
        ".{}-{}.tmp",
        std::process::id(),
        TAKEN.fetch_add(1, Ordering::Relaxed)
    ));
    let aside = PathBuf::from(aside);
    if fs::rename(path, &aside).is_err() {
        return;
    }
    if Seen::read(&aside).is_some_and(|found| found.token != stale.token) {
        let _ = fs::rename(&aside, path);
    } else {
        let _ = fs::remove_file(&aside);
    }
}

/// Name of this machine since it started, and of the space of its process numbers; none where the system does not tell.
fn this_machine() -> Option<String> {
    let boot = fs::read_to_string("/proc/sys/kernel/random/boot_id").ok()?;
    let space = fs::read_link("/proc/self/ns/pid").ok()?;
    Some(format!("{}/{}", boot.trim(), space.display()))
}

/// When a process of this machine started, in ticks of its clock; none where it does not run.
fn start_of(process: u32) -> Option<String> {
    let text = fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // The name of the command, in brackets, may hold spaces; the start is the 20th field behind it.
    Some(text.rsplit_once(')')?.1.split_whitespace().nth(19)?.to_owned())
}

impl Claim {
    /// Creates the file where there is none.
    fn create(path: &Path) -> io::Result<Self> {
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder)?;
        }
        let mut file = OpenOptions::new().write(true).create_new(true).open(path)?;
        let process = std::process::id();
        let token = format!(
            "{} {process} {} {}\n",
            this_machine().unwrap_or_else(|| "unknown".to_owned()),
            start_of(process).unwrap_or_else(|| "0".to_owned()),
            TAKEN.fetch_add(1, Ordering::Relaxed)
        );
        if let Err(error) = file.write_all(token.as_bytes()) {
            let _ = fs::remove_file(path);
            return Err(error);
        }
        Ok(Self {
            path: path.to_owned(),
            token,
            beat: beating(file),
        })
    }
}

/// A thread that sets the time of a claim's file until it is told to end. The file stays open: what has been put in its place by one
/// who took over is left alone.
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
        if Seen::read(&self.path).is_some_and(|found| found.token == self.token) {
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

    #[test]
    fn a_claim_is_one_owners_and_goes_with_it() {
        let entry = entry("one");
        let claim = wait(&entry, || false, || ()).unwrap();
        assert_eq!(
            Claim::create(&beside(&entry)).unwrap_err().kind(),
            io::ErrorKind::AlreadyExists
        );
        drop(claim);
        assert_eq!(fs::read_dir(entry.parent().unwrap()).unwrap().count(), 0);
        fs::remove_dir_all(entry.parent().unwrap()).unwrap();
    }

    #[test]
    fn one_who_waits_ends_when_the_entry_appears() {
        let entry = entry("appears");
        let _claim = wait(&entry, || false, || ()).unwrap();
        let steps = std::cell::Cell::new(0);
        let other = wait(&entry, || steps.get() == 3, || steps.set(steps.get() + 1));
        assert!(other.is_none() && steps.get() == 3);
        fs::remove_dir_all(entry.parent().unwrap()).unwrap();
    }

    /// The first process of a machine never ends while it runs; a start that is not its own shows that the number was given anew.
    #[test]
    #[cfg(target_os = "linux")]
    fn the_claim_of_a_process_that_has_ended_is_taken_over_at_once_and_that_of_another_machine_is_not() {
        let entry = entry("ended");
        let path = beside(&entry);
        let own = std::process::id();
        fs::write(&path, format!("{} {own} 1 0\n", this_machine().unwrap())).unwrap();
        let begin = Instant::now();
        let claim = wait(&entry, || false, || ()).unwrap();
        assert!(begin.elapsed() < STALE / 4);
        drop(claim);
        fs::write(&path, format!("elsewhere {own} 1 0\n")).unwrap();
        let steps = std::cell::Cell::new(0);
        let other = wait(&entry, || steps.get() > 4, || steps.set(steps.get() + 1));
        assert!(other.is_none(), "the claim of another machine was taken over at once");
        fs::remove_dir_all(entry.parent().unwrap()).unwrap();
    }

    #[test]
    fn what_another_one_took_over_is_left_alone() {
        let entry = entry("other");
        let claim = wait(&entry, || false, || ()).unwrap();
        fs::write(beside(&entry), "elsewhere 1 1 0\n").unwrap();
        drop(claim);
        assert!(beside(&entry).exists());
        let stale = Seen {
            token: "gone".to_owned(),
            time: SystemTime::UNIX_EPOCH,
        };
        take_over(&beside(&entry), &stale);
        assert!(beside(&entry).exists(), "a claim that is not the stale one is put back");
        fs::remove_dir_all(entry.parent().unwrap()).unwrap();
    }
}
