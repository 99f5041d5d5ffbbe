//! Arrays of NumPy, in and out.

use crate::errors::wrong;
use fem_core::geometry::Coordinates;
use fem_core::mesh::Mesh;
use fem_core::mesh::id::{FacetId, NodeId};
use fem_core::space::Space;
use mesh_io::MeshArrays;
use mesh_io::vtu::{VtuArray, VtuCells, VtuData, VtuMesh};
use nndd_report::Failure;
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
pub(crate) fn vectors<'py, S: Space>(py: Python<'py>, values: &[S::Vector]) -> PyResult<Bound<'py, PyAny>> {
    rows(py, values.iter().flat_map(|v| v.entries().iter().copied()).collect(), S::DIM)
}

/// Numbers in rows of any length.
pub(crate) struct Rows {
    values: Vec<f64>,
    columns: usize,
}

impl Rows {
    pub(crate) fn read(array: &Bound<'_, PyArray2<f64>>) -> PyResult<Self> {
        let array = array.try_readonly()?;
        let array = array.as_array();
        Ok(Self { values: array.iter().copied().collect(), columns: array.ncols() })
    }

    /// Makes a vector of each row.
    pub(crate) fn vectors<S: Space>(&self) -> Result<Vec<S::Vector>, Failure> {
        if self.columns != S::DIM {
            return Err(Failure::invalid(format!(
                "displacements have rows of {} numbers\n  expected: rows of {} numbers, the components of a displacement in the \
                 space of the case\n  fix: check the shape of the array",
                self.columns,
                S::DIM
            )));
        }
        Ok(self.values.chunks_exact(S::DIM).map(|row| S::Vector::of(|c| row[c])).collect())
    }
}

/// Reads an array with a fixed number of columns, and makes something of each row.
fn of_rows<T: numpy::Element + Copy + Default, const N: usize, R>(
    py: Python<'_>,
    array: &Bound<'_, PyArray2<T>>,
    make: impl Fn([T; N]) -> R,
) -> PyResult<Vec<R>> {
    let array = array.try_readonly()?;
    let array = array.as_array();
    if array.ncols() != N {
        let found = format!("an array has the shape {:?}", array.shape());
        return Err(wrong(py, None, &found, &format!("rows of {N} numbers"), "check the shape of the array"));
    }
    if let Some(values) = array.as_slice() {
        return Ok(values.as_chunks().0.iter().map(|row| make(*row)).collect());
    }
    let row = |row: numpy::ndarray::ArrayView1<'_, T>| {
        let mut values = [T::default(); N];
        values.iter_mut().zip(row).for_each(|(to, from)| *to = *from);
        make(values)
    };
    Ok(array.rows().into_iter().map(row).collect())
}

/// Reads the nodes of cells or facets.
fn of_nodes<const N: usize>(py: Python<'_>, array: &Py<PyArray2<i64>>) -> PyResult<Vec<[u64; N]>> {
    of_rows(py, array.bind(py), |nodes: [i64; N]| nodes.map(number))
}

/// Makes a number of a node or a cell; a negative one becomes one that no mesh has.
fn number(n: i64) -> u64 {
    u64::try_from(n).unwrap_or(u64::MAX)
}

/// A mesh of the package: points (n, 2) or (n, 3), triangles (m, 3) or tetrahedra (m, 4), edges (k, 2) or faces (k, 3) by side, numbers
/// of cells by region. Its arrays cannot be written to, and are not copied.
#[derive(FromPyObject)]
pub(crate) struct GivenMesh {
    points: Py<PyArray2<f64>>,
    #[pyo3(attribute("_cells"))]
    cells: Py<PyArray2<i64>>,
    sides: BTreeMap<String, Py<PyArray2<i64>>>,
    regions: BTreeMap<String, Py<PyArray1<i64>>>,
}

impl GivenMesh {
    pub(crate) fn read(&self, py: Python<'_>) -> PyResult<MeshArrays> {
        let points = self.points.bind(py);
        let points = match points.dims()[1] {
            2 => of_rows(py, points, |[x, y]| [x, y, 0.0])?,
            _ => of_rows(py, points, |point: [f64; 3]| point)?,
        };
        let regions = self.regions.iter().map(|(name, cells)| {
            let cells = cells.bind(py).try_readonly()?;
            Ok((name.clone(), cells.as_array().iter().map(|cell| number(*cell)).collect()))
        });
        let regions = regions.collect::<PyResult<_>>()?;
        let mut made = MeshArrays { points, regions, ..MeshArrays::default() };
        let sides = self.sides.iter();
        if self.cells.bind(py).dims()[1] == 4 {
            made.tetrahedra = of_nodes(py, &self.cells)?;
            let faces = sides.map(|(name, nodes)| Ok((name.clone(), of_nodes(py, nodes)?)));
            made.faces = faces.collect::<PyResult<_>>()?;
        } else {
            made.triangles = of_nodes(py, &self.cells)?;
            let edges = sides.map(|(name, nodes)| Ok((name.clone(), of_nodes(py, nodes)?)));
            made.sides = edges.collect::<PyResult<_>>()?;
        }
        Ok(made)
    }
}

/// Makes points (n, 2), triangles (m, 3) and the edges (k, 2) of each side; of solids points (n, 3), tetrahedra (m, 4) and faces (k, 3).
pub(crate) fn mesh<'py, S: Space>(py: Python<'py>, mesh: &Mesh<S>) -> PyResult<Bound<'py, PyDict>> {
    let node = |n: NodeId| n.index() as i64;
    let facets = mesh.topology().facets();
    let side = |ids: &[FacetId]| ids.iter().flat_map(|facet| facets[*facet]).map(node).collect();
    let sides = mesh.groups().iter().map(|(name, ids)| (name.as_str(), side(ids)));
    let cells = mesh.cells().iter().flat_map(|cell| *cell).map(node);
    of_parts::<S>(py, mesh.points(), cells.collect(), sides)
}

/// Makes a dict of a mesh.
///
/// * `cells`: the nodes of each; `sides`: names, and the nodes of each facet.
pub(crate) fn of_parts<'py, 'a, S: Space>(
    py: Python<'py>,
    points: &[S::Vector],
    cells: Vec<i64>,
    sides: impl Iterator<Item = (&'a str, Vec<i64>)>,
) -> PyResult<Bound<'py, PyDict>> {
    let (made, by_name) = (PyDict::new(py), PyDict::new(py));
    for (name, ends) in sides {
        by_name.set_item(name, rows(py, ends, S::DIM)?)?;
    }
    made.set_item("points", vectors::<S>(py, points)?)?;
    made.set_item(S::WORDS.cells, rows(py, cells, 1 + S::DIM)?)?;
    made.set_item("sides", by_name)?;
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

/// Makes points (n, 3), cells (m, corners) and the fields of a grid at its points and in its cells.
pub(crate) fn grid<'py>(py: Python<'py>, mesh: VtuMesh, data: VtuData) -> PyResult<Bound<'py, PyDict>> {
    let made = PyDict::new(py);
    made.set_item("points", rows(py, mesh.points.into_flattened(), 3)?)?;
    let (corners, nodes) = match &mesh.cells {
        VtuCells::Lines(cells) => (2, cells.as_flattened()),
        VtuCells::Triangles(cells) => (3, cells.as_flattened()),
        VtuCells::Tetrahedra(cells) => (4, cells.as_flattened()),
    };
    made.set_item("cells", rows(py, nodes.iter().map(|node| i64::from(*node)).collect(), corners)?)?;
    for (place, fields) in [("point_data", data.point), ("cell_data", data.cell)] {
        let by_name = PyDict::new(py);
        for array in fields {
            by_name.set_item(array.name.clone(), field(py, array)?)?;
        }
        made.set_item(place, by_name)?;
    }
    Ok(made)
}
