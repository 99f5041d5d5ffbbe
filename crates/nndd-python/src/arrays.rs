//! Arrays of NumPy, in and out.

use crate::errors::wrong;
use fem_core::geometry::Vector;
use fem_core::mesh::TriMesh;
use mesh_io::MeshArrays;
use mesh_io::vtu::VtuArray;
use numpy::{PyArray1, PyArray2, PyArrayMethods};
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
pub(crate) fn read_vectors(py: Python<'_>, array: &Bound<'_, PyArray2<f64>>) -> PyResult<Vec<Vector>> {
    Ok(of_rows(py, array)?.into_iter().map(|[x, y]| Vector::new(x, y)).collect())
}

/// Reads an array with a fixed number of columns.
fn of_rows<T: numpy::Element + Copy + Default, const N: usize>(
    py: Python<'_>,
    array: &Bound<'_, PyArray2<T>>,
) -> PyResult<Vec<[T; N]>> {
    let array = array.try_readonly()?;
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

/// A mesh of the package: points (n, 2) or (n, 3), triangles (m, 3), edges (k, 2) by side, numbers of triangles by region. Its
/// arrays cannot be written to, and are not copied.
#[derive(FromPyObject)]
pub(crate) struct GivenMesh {
    points: Py<PyArray2<f64>>,
    triangles: Py<PyArray2<i64>>,
    sides: BTreeMap<String, Py<PyArray2<i64>>>,
    regions: BTreeMap<String, Py<PyArray1<i64>>>,
}

impl GivenMesh {
    /// Counts the points.
    pub(crate) fn node_count(&self, py: Python<'_>) -> usize {
        self.points.bind(py).dims()[0]
    }

    pub(crate) fn read(&self, py: Python<'_>) -> PyResult<MeshArrays> {
        // A negative number becomes one that no mesh has.
        let number = |n: i64| u64::try_from(n).unwrap_or(u64::MAX);
        let points = self.points.bind(py);
        let points = match points.dims()[1] {
            2 => of_rows::<f64, 2>(py, points)?.into_iter().map(|[x, y]| [x, y, 0.0]).collect(),
            _ => of_rows::<f64, 3>(py, points)?,
        };
        let sides = self.sides.iter().map(|(name, edges)| {
            let edges = of_rows::<i64, 2>(py, edges.bind(py))?.into_iter().map(|edge| edge.map(number));
            Ok((name.clone(), edges.collect()))
        });
        let regions = self.regions.iter().map(|(name, cells)| {
            let cells = cells.bind(py).try_readonly()?;
            Ok((name.clone(), cells.as_array().iter().map(|cell| number(*cell)).collect()))
        });
        let triangles = of_rows::<i64, 3>(py, self.triangles.bind(py))?;
        Ok(MeshArrays {
            points,
            triangles: triangles.into_iter().map(|corners| corners.map(number)).collect(),
            sides: sides.collect::<PyResult<_>>()?,
            regions: regions.collect::<PyResult<_>>()?,
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

/// Makes the array of a field.
pub(crate) fn field(py: Python<'_>, field: VtuArray) -> PyResult<Bound<'_, PyAny>> {
    let VtuArray { components, values, whole, .. } = field;
    Ok(match (components, whole) {
        (1, true) => PyArray1::from_iter(py, values.iter().map(|v| *v as i64)).into_any(),
        (1, false) => PyArray1::from_vec(py, values).into_any(),
        _ => rows(py, values, components)?,
    })
}
