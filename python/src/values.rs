//! Conversion between Python values and JSON.

use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString};
use serde_json::{Map, Number, Value};

use crate::failure::option_error;

pub fn read(any: &Bound<PyAny>) -> PyResult<Value> {
    if any.is_none() {
        Ok(Value::Null)
    } else if any.is_instance_of::<PyBool>() {
        any.extract().map(Value::Bool)
    } else if any.is_instance_of::<PyInt>() {
        let whole = any.extract::<i64>().map(Value::from).or_else(|_| any.extract::<u64>().map(Value::from));
        whole.map_err(|_| option_error("a whole number is too large: give one below 2^64"))
    } else if any.is_instance_of::<PyFloat>() {
        let number = Number::from_f64(any.extract()?);
        number.map(Value::Number).ok_or_else(|| option_error(format!("{any}: give a finite number")))
    } else if any.is_instance_of::<PyString>() {
        any.extract().map(Value::String)
    } else if let Ok(items) = any.cast::<PyDict>() {
        let name_error = |name: &Bound<PyAny>| option_error(format!("{name}: give names as text"));
        let entry = |(name, item): (Bound<PyAny>, Bound<PyAny>)| {
            Ok((name.extract().map_err(|_| name_error(&name))?, read(&item)?))
        };
        items.iter().map(entry).collect::<PyResult<Map<String, Value>>>().map(Value::Object)
    } else {
        any.try_iter()?.map(|item| read(&item?)).collect::<PyResult<Vec<Value>>>().map(Value::Array)
    }
}

pub fn to_python(py: Python, value: &Value) -> PyResult<Py<PyAny>> {
    Ok(match value {
        Value::Null => py.None(),
        Value::Bool(is) => is.into_pyobject(py)?.to_owned().into_any().unbind(),
        Value::Number(number) => match (number.as_i64(), number.as_u64()) {
            (Some(whole), _) => whole.into_pyobject(py)?.into_any().unbind(),
            (None, Some(whole)) => whole.into_pyobject(py)?.into_any().unbind(),
            (None, None) => number.as_f64().unwrap_or(f64::NAN).into_pyobject(py)?.into_any().unbind(),
        },
        Value::String(text) => text.into_pyobject(py)?.into_any().unbind(),
        Value::Array(items) => {
            let items: Vec<Py<PyAny>> = items.iter().map(|item| to_python(py, item)).collect::<PyResult<_>>()?;
            PyList::new(py, items)?.into_any().unbind()
        }
        Value::Object(items) => {
            let object = PyDict::new(py);
            items.iter().try_for_each(|(name, item)| object.set_item(name, to_python(py, item)?))?;
            object.into_any().unbind()
        }
    })
}
