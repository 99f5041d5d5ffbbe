//! JSON values as Python objects.

use pyo3::prelude::*;
use serde_json::Value;

/// Makes a dict, list, number or text of a value; every number is the same to the last bit.
pub(crate) fn loads<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?.getattr("loads")?.call1((value.to_string(),))
}
