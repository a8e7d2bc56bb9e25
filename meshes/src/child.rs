//! Runs a child program that ends when this process ends, for whatever reason.
//!
//! A signal that cannot be caught (`kill -9`) ends this process without a chance to end its child. A shell therefore
//! starts the program and watches a pipe whose other end this process holds open. The system closes that end when the
//! process dies, and the shell then kills the program. Without a POSIX shell (Windows), the program runs to completion.

use std::ffi::OsStr;
use std::io;
use std::process::{Command, ExitStatus, Output, Stdio};

/// Starts its arguments as a command and kills the command when standard input closes. The watcher does not share the
/// program's pipes, and it ends before the process number can be reused. A terminal sends Ctrl-C to all of them, but
/// handling it is left to this process: the program ends with it without output.
#[cfg(unix)]
const WATCHED: &str = r#"
trap '' INT HUP
exec 3<&0
( [ -z "$PROCESSOR_SECONDS" ] || ulimit -t "$PROCESSOR_SECONDS"; exec "$@" ) </dev/null 3<&- & child=$!
{ read -r _ <&3; kill -KILL "$child"; } >/dev/null 2>&1 & watcher=$!
exec 2>/dev/null
wait "$child"; status=$?
kill "$watcher"; wait "$watcher"
exit "$status"
"#;

/// The shell variable that contains the time limit.
const SECONDS: &str = "PROCESSOR_SECONDS";

/// Exit statuses of a shell that cannot start a program.
#[cfg(unix)]
const NOT_STARTED: [i32; 2] = [126, 127];

/// Prepares a program that can take further arguments.
pub fn command(program: impl AsRef<OsStr>) -> Command {
    #[cfg(unix)]
    {
        let mut command = Command::new("/bin/sh");
        command.args(["-c", WATCHED, "sh"]).arg(program);
        command
    }
    #[cfg(not(unix))]
    Command::new(program)
}

/// Limits the processor time of a [`command()`] \[s\]; on Windows it remains unlimited.
pub(crate) fn limit(command: &mut Command, seconds: u64) {
    command.env(SECONDS, seconds.to_string());
}

/// Whether the system ended a program because it exceeded its [`limit`].
pub(crate) fn ran_out(output: &Output) -> bool {
    // The shell adds 128 to SIGKILL (9) and SIGXCPU (24).
    output.status.code().is_some_and(|code| [137, 152].contains(&code))
}

/// Runs a [`command()`] to completion.
///
/// # Errors
/// The reason why it cannot be started.
pub fn output(command: &mut Command) -> io::Result<Output> {
    let streams = command
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    let mut child = streams.spawn()?;
    // This pipe must stay open, because the shell waits for it to close.
    let open = child.stdin.take();
    let output = child.wait_with_output()?;
    drop(open);
    #[cfg(unix)]
    if output.status.code().is_some_and(|code| NOT_STARTED.contains(&code)) {
        let said = String::from_utf8_lossy(&output.stderr);
        return Err(io::Error::other(
            said.trim().lines().last().unwrap_or_default().to_owned(),
        ));
    }
    Ok(output)
}

/// Runs a [`command()`] to completion with this process's output streams. Returns its status; the shell adds 128 to the
/// number of a signal.
///
/// # Errors
/// If it cannot be started or waited for.
pub fn status(command: &mut Command) -> io::Result<ExitStatus> {
    let mut child = command.stdin(Stdio::piped()).spawn()?;
    // Waiting must not close this pipe, because the shell waits for it to close.
    let open = child.stdin.take();
    let status = child.wait();
    drop(open);
    status
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn the_status_is_that_of_the_program_or_of_the_signal_that_ended_it() -> io::Result<()> {
        for (script, expected) in [("exit 7", 7), ("exit 0", 0), ("kill -KILL $$", 137)] {
            assert_eq!(
                status(command("sh").args(["-c", script]))?.code(),
                Some(expected),
                "{script}"
            );
        }
        Ok(())
    }

    #[test]
    fn output_and_status_are_those_of_the_program() -> io::Result<()> {
        let output = output(command("sh").args(["-c", "echo a b; echo c >&2; exit 5"]))?;
        assert_eq!(
            (output.status.code(), &output.stdout[..], &output.stderr[..]),
            (Some(5), &b"a b\n"[..], &b"c\n"[..])
        );
        Ok(())
    }

    #[test]
    fn a_program_ends_at_its_limit() -> io::Result<()> {
        let mut endless = command("sh");
        limit(endless.args(["-c", "while :; do :; done"]), 1);
        assert!(ran_out(&output(&mut endless)?));
        Ok(())
    }

    #[test]
    fn a_program_that_does_not_exist_is_an_error() {
        let error = output(&mut command("no-such-program"))
            .err()
            .map(|error| error.to_string());
        assert!(error.is_some_and(|error| error.contains("no-such-program")));
    }
}
