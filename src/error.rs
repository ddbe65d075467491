//! What can go wrong, in sentences that name the place and how to fix it.

use std::path::{Path, PathBuf};

/// How a path is printed.
pub trait Shown {
    /// As its system writes it: on Windows with one kind of separator, whatever its parts were joined with.
    fn shown(&self) -> String;
}

impl Shown for Path {
    #[expect(clippy::disallowed_methods, reason = "everybody else prints paths by this one")]
    fn shown(&self) -> String {
        let path = self.display().to_string();
        if cfg!(windows) { path.replace('/', "\\") } else { path }
    }
}

/// The crate's result type.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// One error; `Display` gives one sentence for the user.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be read or written.
    #[error("cannot {action} {}: {source}", path.shown())]
    Io {
        /// "read", "write", "create", ...
        action: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// A file was read but its text is not what its format asks for.
    #[error("{}{}: {message}", path.shown(), line.map(|l| format!(", line {l}")).unwrap_or_default())]
    Parse {
        /// The file.
        path: PathBuf,
        /// 1-based line, where the format has lines.
        line: Option<usize>,
        /// What is wrong, and what to do.
        message: String,
    },
    /// Data or options that cannot be worked with.
    #[error("{0}")]
    InvalidInput(String),
    /// A valid wish that this version cannot fulfil.
    #[error("{0}")]
    Unsupported(String),
    /// A program started by us failed.
    #[error("{program}: {message}")]
    ExternalProgram {
        /// Its name, e.g. "tetgen".
        program: String,
        /// What happened, translated into words.
        message: String,
    },
    /// A linear system has no unique solution.
    #[error("{0}")]
    Singular(String),
    /// The nonlinear solver could not make further progress and there is no result to return.
    #[error("{0}")]
    Diverged(String),
    /// The caller asked to stop before there was a result.
    #[error("stopped on request before there was a result")]
    Cancelled,
}

impl Error {
    /// An [`Error::InvalidInput`] from anything printable.
    pub fn invalid(message: impl Into<String>) -> Self {
        Self::InvalidInput(message.into())
    }

    /// An [`Error::Io`] for `path`.
    pub fn io(action: &'static str, path: &Path, source: std::io::Error) -> Self {
        Self::Io { action, path: path.to_path_buf(), source }
    }

    /// An [`Error::Parse`] at a 1-based line, or for the whole file.
    pub fn parse(path: &Path, line: impl Into<Option<usize>>, message: impl Into<String>) -> Self {
        Self::Parse { path: path.to_path_buf(), line: line.into(), message: message.into() }
    }
}
