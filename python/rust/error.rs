//! Exceptions of the package, with the messages of the library.

use std::fmt::Display;

use musculo_collide::Interrupted;
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;

pyo3::import_exception!(musculo_collide._errors, InputError);
pyo3::import_exception!(musculo_collide._errors, FileError);
pyo3::import_exception!(musculo_collide._errors, InUseError);

/// Returns the exception for input that the library refuses.
pub(crate) fn refused(error: impl Display) -> PyErr {
    InputError::new_err(error.to_string())
}

/// Returns the exception for a file that cannot be read or written.
pub(crate) fn unreadable(error: impl Display) -> PyErr {
    FileError::new_err(error.to_string())
}

/// Returns the exception for an object that another call uses.
pub(crate) fn in_use(message: String) -> PyErr {
    InUseError::new_err(message)
}

/// Returns the exception for a call that was interrupted without a reason of its own.
pub(crate) fn interrupted() -> PyErr {
    PyKeyboardInterrupt::new_err(Interrupted.to_string())
}
