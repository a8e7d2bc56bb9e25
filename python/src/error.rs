//! Errors of the library as exceptions of Python: message, remedy, and the place in the design file.

use std::fmt::Display;

use miette::Diagnostic;
use nailnoise::Error;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::{PyErr, create_exception};
use serde::Serialize;

create_exception!(
    nailnoise._native,
    NailnoiseError,
    pyo3::exceptions::PyException,
    "A design, a file or a computation that failed; `help`, `file`, `line`, `key`, `code` and `status` say more."
);

create_exception!(
    nailnoise._native,
    NoCacheError,
    NailnoiseError,
    "The user's cache cannot be used, and work can go on without it."
);

/// Reason why work on a separate thread failed.
pub(crate) enum Refused {
    /// An error of the library.
    Library(Box<Error>),
    /// An impossible argument.
    Value(String),
}

impl From<Error> for Refused {
    fn from(error: Error) -> Self {
        Self::Library(Box::new(error))
    }
}

impl From<Refused> for PyErr {
    fn from(refused: Refused) -> Self {
        match refused {
            Refused::Library(error) => raised(*error),
            Refused::Value(message) => value_error(message),
        }
    }
}

/// An impossible argument.
pub(crate) fn value_error(message: impl Display) -> PyErr {
    PyValueError::new_err(message.to_string())
}

/// The exception for an error of the library.
pub(crate) fn raised(error: Error) -> PyErr {
    let causes = std::iter::successors(std::error::Error::source(&error), |cause| cause.source());
    let causes: String = causes.map(|cause| format!(": {cause}")).collect();
    let message = format!("{error}{causes}");
    let text = |part: Option<Box<dyn Display + '_>>| part.map(|part| part.to_string());
    let (help, code) = (text(Diagnostic::help(&error)), text(Diagnostic::code(&error)));
    let (file, line) = place(&error);
    let key = match &error {
        Error::Design(design) => design.key().map(str::to_owned),
        _ => None,
    };
    let status = error.exit_status();
    Python::attach(|py| {
        let exception = NailnoiseError::new_err(message);
        let value = exception.value(py);
        let set = || -> PyResult<()> {
            value.setattr("help", help)?;
            value.setattr("code", code)?;
            value.setattr("file", file)?;
            value.setattr("line", line)?;
            value.setattr("key", key)?;
            value.setattr("status", status)
        };
        match set() {
            Ok(()) => exception,
            Err(other) => other,
        }
    })
}

/// File and line of an error in a design, from 1.
fn place(error: &Error) -> (Option<String>, Option<usize>) {
    let label = Diagnostic::labels(error).and_then(|mut labels| labels.next());
    let source = Diagnostic::source_code(error);
    let found = label
        .zip(source)
        .and_then(|(label, source)| source.read_span(label.inner(), 0, 0).ok());
    found.map_or((None, None), |found| {
        (found.name().map(str::to_owned), Some(found.line() + 1))
    })
}

/// A value as JSON.
pub(crate) fn json_of<T: Serialize + ?Sized>(value: &T) -> PyResult<String> {
    serde_json::to_string_pretty(value).map_err(|error| raised(Error::Json(error)))
}
