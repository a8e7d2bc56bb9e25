//! Red text for failures.

use std::io::IsTerminal as _;

/// Red text for standard output; unchanged if standard output is not a terminal or NO_COLOR is set.
pub(super) fn red(text: &str) -> String {
    let colour = std::io::stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
    if colour {
        format!("\u{1b}[1;31m{text}\u{1b}[0m")
    } else {
        text.to_owned()
    }
}
