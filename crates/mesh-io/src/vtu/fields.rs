//! Nodal fields of grids that other programs wrote.

use fem_core::geometry::Vector;
use std::path::Path;
use thiserror::Error;
use vtkio::model::{Attribute, DataSet, UnstructuredGridPiece};

/// A vector at each point of a grid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointVectors {
    /// The points, m.
    pub points: Vec<Vector>,
    /// The vectors, in the order of the points.
    pub values: Vec<Vector>,
}

/// Why a field could not be read.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum FieldError {
    /// The file cannot be read, or it is no unstructured grid.
    #[error("{reason}")]
    File {
        /// Why.
        reason: String,
    },
    /// No array of the points has one of the names.
    #[error("the points have no array of two or three components called {wanted}; their arrays are: {known}")]
    NoSuchArray {
        /// The names looked for.
        wanted: String,
        /// The arrays of the points.
        known: String,
    },
    /// A number is infinite or NaN.
    #[error("point {point} has the value {value}")]
    NotFinite {
        /// The point, from 0.
        point: usize,
        /// What was found.
        value: f64,
    },
}

/// Reads a vector at each point of a `.vtu` file (VTK XML: text, binary or appended, also compressed by zlib) or of a legacy `.vtk` file.
///
/// * `names`: of the array; the first that is there is read. A third component is left out.
///
/// # Errors
/// See [`FieldError`].
pub fn point_vectors(path: &Path, names: &[&str]) -> Result<PointVectors, FieldError> {
    let fault = |reason: String| FieldError::File { reason };
    let file = vtkio::Vtk::import(path).map_err(|error| fault(error.to_string()))?;
    let source = file.file_path.clone();
    let DataSet::UnstructuredGrid { pieces, .. } = file.data else {
        return Err(fault("it is not an unstructured grid".to_owned()));
    };
    let mut all = PointVectors::default();
    for piece in pieces {
        let piece =
            piece.into_loaded_piece_data(source.as_deref()).map_err(|error| fault(error.to_string()))?;
        add(&mut all, &piece, names)?;
    }
    let numbers = all.points.iter().chain(&all.values).enumerate();
    for (k, v) in numbers {
        if let Some(value) = v.iter().find(|x| !x.is_finite()) {
            return Err(FieldError::NotFinite { point: k % all.points.len(), value: *value });
        }
    }
    Ok(all)
}

fn add(all: &mut PointVectors, piece: &UnstructuredGridPiece, names: &[&str]) -> Result<(), FieldError> {
    let numbers = |reason: &str| FieldError::File { reason: reason.to_owned() };
    let points = piece.points.cast_into::<f64>().ok_or_else(|| numbers("its points are not numbers"))?;
    let count = points.len() / 3;
    let arrays: Vec<_> = piece
        .data
        .point
        .iter()
        .filter_map(|attribute| match attribute {
            Attribute::DataArray(array) => Some(array),
            Attribute::Field { .. } => None,
        })
        .collect();
    let components = |length: usize| length.checked_div(count).unwrap_or(3);
    let named = |name: &&str| {
        arrays.iter().find(|a| a.name.eq_ignore_ascii_case(name) && matches!(components(a.data.len()), 2 | 3))
    };
    let Some(array) = names.iter().find_map(named) else {
        let known: Vec<&str> = arrays.iter().map(|array| array.name.as_str()).collect();
        return Err(FieldError::NoSuchArray { wanted: names.join(", "), known: known.join(", ") });
    };
    let values = array.data.cast_into::<f64>().ok_or_else(|| numbers("its array is not of numbers"))?;
    all.points.extend(points.chunks_exact(3).map(|p| Vector::new(p[0], p[1])));
    all.values.extend(values.chunks_exact(components(values.len())).map(|v| Vector::new(v[0], v[1])));
    Ok(())
}
