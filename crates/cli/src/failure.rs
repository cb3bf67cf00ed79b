//! Exit codes.

use std::process::ExitCode;

use stack::Fault;

/// How a command that did its work ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// All is well: exit 0.
    Done,
    /// A limit was exceeded or a target missed: exit 1.
    No,
    /// Interrupted, and what there is was kept: exit 130.
    Interrupted,
}

impl From<Verdict> for ExitCode {
    fn from(verdict: Verdict) -> Self {
        match verdict {
            Verdict::Done => Self::SUCCESS,
            Verdict::No => Self::from(1),
            Verdict::Interrupted => Self::from(130),
        }
    }
}

/// A mistake in the call that `clap` cannot see.
#[derive(Debug)]
pub struct UsageError(pub String);

impl std::fmt::Display for UsageError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for UsageError {}

/// A usage error as an [`anyhow::Error`].
pub fn usage(message: impl Into<String>) -> anyhow::Error {
    UsageError(message.into()).into()
}

/// An error in other words than those it came with.
#[derive(Debug)]
pub struct Blamed {
    /// What is said.
    pub message: String,
    /// Whose fault it was before, and is.
    pub fault: Fault,
}

impl std::fmt::Display for Blamed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Blamed {}

/// What the first error in the chain that says whose fault it is says.
pub fn fault_of(error: &anyhow::Error) -> Fault {
    error.chain().find_map(fault).unwrap_or(Fault::Machine)
}

/// The exit code that goes with that.
pub fn exit_code(error: &anyhow::Error) -> ExitCode {
    match fault_of(error) {
        Fault::Usage | Fault::Input => ExitCode::from(2),
        Fault::Machine => ExitCode::from(3),
        Fault::Interrupted => ExitCode::from(130),
    }
}

fn fault(error: &(dyn std::error::Error + 'static)) -> Option<Fault> {
    macro_rules! ask {
        ($($type:ty),*) => { $(if let Some(error) = error.downcast_ref::<$type>() { return Some(error.fault()); })* };
    }
    ask!(
        stack::file::FileError,
        stack::file::PassError,
        stack::merge::MergeError,
        tracer::scene::SceneError,
        tracer::integrator::TraceError,
        tracer::camera::CameraError,
        tracer::film::NotAFilm,
        reconstruct::ReconstructError,
        reconstruct::blend::BlendError,
        reconstruct::metrics::ComparisonError
    );
    if let Some(Blamed { fault, .. }) = error.downcast_ref() {
        return Some(*fault);
    }
    if error.is::<UsageError>() || error.is::<stack::KnobError>() {
        return Some(Fault::Usage);
    }
    error.is::<stack::Cancelled>().then_some(Fault::Interrupted)
}
