//! Conversion between numpy arrays and rows of numbers.

use numpy::{Element, PyArray1, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::failure::invalid_array;

pub fn rows<'a, T: Element, const N: usize>(array: &'a PyReadonlyArray2<T>, what: &str) -> PyResult<&'a [[T; N]]> {
    let [n_rows, n_columns] = [0, 1].map(|axis| array.shape()[axis]);
    if n_columns != N {
        return Err(invalid_array(format!("{what}: {n_rows} x {n_columns} numbers: give {N} a row")));
    }
    let numbers = array.as_slice().map_err(|_| invalid_array(format!("{what}: the array is not contiguous")))?;
    Ok(numbers.as_chunks().0)
}

pub fn numbers<'a, T: Element>(array: &'a PyReadonlyArray1<T>, what: &str) -> PyResult<&'a [T]> {
    array.as_slice().map_err(|_| invalid_array(format!("{what}: the array is not contiguous")))
}

pub fn array<T: Element, const N: usize>(py: Python, rows: Vec<[T; N]>) -> PyResult<Py<PyAny>> {
    let n = rows.len();
    Ok(PyArray1::from_vec(py, rows.into_flattened()).reshape([n, N])?.into_any().unbind())
}

/// Converts numbers, row by row, to an array of `n_columns` columns without a copy.
pub fn table<T: Element>(py: Python, numbers: Vec<T>, n_columns: usize) -> PyResult<Py<PyAny>> {
    let n = numbers.len() / n_columns.max(1);
    Ok(PyArray1::from_vec(py, numbers).reshape([n, n_columns])?.into_any().unbind())
}

/// Converts indices below 2^30, n x 3, to an array of `int32` without a copy.
pub fn triples(py: Python, rows: Vec<[u32; 3]>) -> PyResult<Py<PyAny>> {
    to_signed(py, array(py, rows)?)
}

pub fn sequence<T: Element>(py: Python, numbers: Vec<T>) -> Py<PyAny> {
    PyArray1::from_vec(py, numbers).into_any().unbind()
}

/// Converts indices to an array of `int32` without a copy; `u32::MAX` becomes -1.
pub fn indices(py: Python, numbers: Vec<u32>) -> PyResult<Py<PyAny>> {
    to_signed(py, sequence(py, numbers))
}

fn to_signed(py: Python, array: Py<PyAny>) -> PyResult<Py<PyAny>> {
    array.call_method1(py, "view", ("int32",))
}

pub fn points(array: &PyReadonlyArray2<f32>, what: &str) -> PyResult<Vec<[f32; 3]>> {
    let points: &[[f32; 3]] = rows(array, what)?;
    match points.iter().position(|point| !point.iter().all(|x| x.is_finite())) {
        Some(row) => Err(invalid_array(format!("{what}: row {row} has a number that is not finite"))),
        None => Ok(points.to_vec()),
    }
}

pub fn indices_below<const N: usize>(array: &PyReadonlyArray2<i64>, n: usize, what: &str) -> PyResult<Vec<[u32; N]>> {
    // The library uses 32-bit indices, and a graph counts both directions of an edge and loops.
    let (limit, given) = ((u32::MAX / 4) as usize, rows(array, what)?);
    if given.len().max(n) > limit {
        return Err(invalid_array(format!("{what}: {} rows over {n}: give at most {limit}", given.len())));
    }
    let is_bad = |&index: &i64| !(0..n as i64).contains(&index);
    match given.iter().enumerate().find_map(|(at, row)| row.iter().find(|index| is_bad(index)).map(|&bad| (at, bad))) {
        Some((at, bad)) => Err(invalid_array(format!("{what}: row {at} names {bad}, but there are only {n}"))),
        None => Ok(given.iter().map(|row: &[i64; N]| row.map(|index| index as u32)).collect()),
    }
}
