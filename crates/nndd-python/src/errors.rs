//! Failures of the library as exceptions of the package.

use nndd_report::Failure;
use nndd_report::failure::{COMMAND_LINE, Finding};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Makes the exception of a failure.
pub(crate) fn exception(py: Python<'_>, failure: &Failure) -> PyErr {
    let findings = failure.findings();
    make(py, failure.code, &findings).unwrap_or_else(|error| error)
}

/// Makes the exception of a wrong argument.
pub(crate) fn wrong(py: Python<'_>, place: Option<&str>, found: &str, expected: &str, fix: &str) -> PyErr {
    let refuse = py.import("nndd._errors").and_then(|errors| errors.getattr("refuse"));
    match refuse.and_then(|refuse| refuse.call1((place, found, expected, fix))) {
        Err(error) => error,
        Ok(_) => exception(py, &Failure::plain(COMMAND_LINE, found)),
    }
}

fn make(py: Python<'_>, code: u8, findings: &[Finding]) -> PyResult<PyErr> {
    let dict = |finding: &Finding| {
        let dict = PyDict::new(py);
        let place = finding.place.as_ref().map(ToString::to_string);
        let place = place.map(|place| place.trim_start_matches("--set ").to_owned());
        dict.set_item("place", place)?;
        dict.set_item("found", &finding.found)?;
        dict.set_item("expected", &finding.expected)?;
        dict.set_item("fix", &finding.fix)?;
        Ok(dict)
    };
    let findings = findings.iter().map(dict).collect::<PyResult<Vec<_>>>()?;
    let made = py.import("nndd._errors")?.getattr("of_failure")?.call1((code, findings))?;
    Ok(PyErr::from_value(made))
}
