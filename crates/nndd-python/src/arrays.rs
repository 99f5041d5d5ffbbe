//! Arrays of NumPy, in and out.

use crate::errors::wrong;
use fem_core::geometry::Vector;
use fem_core::mesh::TriMesh;
use mesh_io::MeshArrays;
use mesh_io::vtu::{VtuArray, VtuData};
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::BTreeMap;

/// Makes an array with some numbers in each row.
pub(crate) fn rows<'py, T: numpy::Element>(
    py: Python<'py>,
    values: Vec<T>,
    columns: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let shape = [values.len() / columns, columns];
    Ok(PyArray1::from_vec(py, values).reshape(shape)?.into_any())
}

/// Makes an array of vectors, one per row.
pub(crate) fn vectors<'py>(py: Python<'py>, values: &[Vector]) -> PyResult<Bound<'py, PyAny>> {
    rows(py, values.iter().flat_map(|v| [v[0], v[1]]).collect(), 2)
}

/// Reads vectors, one per row.
pub(crate) fn read_vectors(py: Python<'_>, array: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<Vector>> {
    Ok(of_rows(py, array)?.into_iter().map(|[x, y]| Vector::new(x, y)).collect())
}

/// Reads an array with a fixed number of columns.
fn of_rows<T: numpy::Element + Copy + Default, const N: usize>(
    py: Python<'_>,
    array: &PyReadonlyArray2<'_, T>,
) -> PyResult<Vec<[T; N]>> {
    let array = array.as_array();
    if array.ncols() != N {
        let found = format!("an array has the shape {:?}", array.shape());
        return Err(wrong(py, None, &found, &format!("rows of {N} numbers"), "check the shape of the array"));
    }
    let row = |row: numpy::ndarray::ArrayView1<'_, T>| {
        let mut values = [T::default(); N];
        values.iter_mut().zip(row).for_each(|(to, from)| *to = *from);
        values
    };
    Ok(array.rows().into_iter().map(row).collect())
}

/// A mesh of the package: points (n, 3), triangles (m, 3), edges (k, 2) by side, numbers of triangles by region.
#[derive(FromPyObject)]
pub(crate) struct GivenMesh<'py> {
    points: PyReadonlyArray2<'py, f64>,
    triangles: PyReadonlyArray2<'py, i64>,
    sides: BTreeMap<String, PyReadonlyArray2<'py, i64>>,
    regions: BTreeMap<String, PyReadonlyArray1<'py, i64>>,
}

impl GivenMesh<'_> {
    pub(crate) fn read(&self, py: Python<'_>) -> PyResult<MeshArrays> {
        // A negative number becomes one that no mesh has.
        let number = |n: i64| u64::try_from(n).unwrap_or(u64::MAX);
        let sides = self.sides.iter().map(|(name, edges)| {
            let edges = of_rows::<i64, 2>(py, edges)?.into_iter().map(|edge| edge.map(number));
            Ok((name.clone(), edges.collect()))
        });
        let regions = self.regions.iter().map(|(name, cells)| {
            (name.clone(), cells.as_array().iter().map(|cell| number(*cell)).collect())
        });
        let triangles = of_rows::<i64, 3>(py, &self.triangles)?;
        Ok(MeshArrays {
            points: of_rows::<f64, 3>(py, &self.points)?,
            triangles: triangles.into_iter().map(|corners| corners.map(number)).collect(),
            sides: sides.collect::<PyResult<_>>()?,
            regions: regions.collect(),
        })
    }
}

/// Makes points (n, 2), triangles (m, 3) and the edges (k, 2) of each side.
pub(crate) fn mesh<'py>(py: Python<'py>, mesh: &TriMesh) -> PyResult<Bound<'py, PyDict>> {
    let node = |n: fem_core::mesh::id::NodeId| n.index() as i64;
    let sides = PyDict::new(py);
    for (name, edges) in mesh.groups() {
        let ends = edges.iter().flat_map(|edge| mesh.topology().edges()[*edge].map(node));
        sides.set_item(name, rows(py, ends.collect(), 2)?)?;
    }
    let made = PyDict::new(py);
    made.set_item("points", vectors(py, mesh.points())?)?;
    made.set_item("triangles", rows(py, mesh.triangles().iter().flat_map(|t| t.map(node)).collect(), 3)?)?;
    made.set_item("sides", sides)?;
    Ok(made)
}

/// Makes the fields of a grid by their names, those at points first.
pub(crate) fn fields<'py>(py: Python<'py>, data: VtuData) -> PyResult<[Bound<'py, PyDict>; 2]> {
    let of = |arrays: Vec<VtuArray>| {
        let dict = PyDict::new(py);
        for VtuArray { name, components, values, whole } in arrays {
            let array = match (components, whole) {
                (1, true) => PyArray1::from_iter(py, values.iter().map(|v| *v as i64)).into_any(),
                (1, false) => PyArray1::from_vec(py, values).into_any(),
                _ => rows(py, values, components)?,
            };
            dict.set_item(name, array)?;
        }
        PyResult::Ok(dict)
    };
    Ok([of(data.point)?, of(data.cell)?])
}
