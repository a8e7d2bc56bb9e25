//! Exit status of a command.
//!
//! `std::process::ExitCode` does not give access to its number, which the Python package passes to `sys.exit`.

use std::process::ExitCode;

/// Exit status of a command: 0 done; 1 done, but a limit is not met; 2 wrong usage or input; 3 a numerical check
/// failed; 101 a fault of the program; 130 interrupted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Status(u8);

impl Status {
    /// Done.
    pub const SUCCESS: Self = Self(0);

    /// The number that the operating system receives.
    pub fn code(self) -> u8 {
        self.0
    }
}

impl From<u8> for Status {
    fn from(code: u8) -> Self {
        Self(code)
    }
}

impl From<Status> for ExitCode {
    fn from(status: Status) -> Self {
        Self::from(status.0)
    }
}
