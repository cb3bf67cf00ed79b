//! Standard error, which may be closed, or a full disk.

use std::io::Write;

/// Says `line` and ends it. That nobody can hear it is no reason to lose the work: it goes on.
pub fn say_line(line: impl std::fmt::Display) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}
