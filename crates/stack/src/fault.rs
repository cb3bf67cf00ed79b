//! Whose fault an error is.

/// Whose fault an error is; the command line turns it into the exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The call is wrong: a flag, a value, a combination.
    Usage,
    /// A file that was read is missing, damaged or not what it should be.
    Input,
    /// The machine failed: disk full, no permission, out of memory.
    Machine,
    /// Nobody's: the work was interrupted.
    Interrupted,
}
