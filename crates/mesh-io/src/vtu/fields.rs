//! Nodal fields of grids that other programs wrote.

use super::document::{Array, Document, VTK_AXES, fault};
use fem_core::geometry::Coordinates;
use fem_core::space::{Plane, Space};
use thiserror::Error;

/// A vector at each point of a grid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointVectors<S: Space = Plane> {
    /// The points, m.
    pub points: Vec<S::Vector>,
    /// The vectors, in the order of the points.
    pub values: Vec<S::Vector>,
    /// The line of each point in a table, from 1; empty for a grid.
    pub lines: Vec<usize>,
}

/// Why a field could not be read.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum FieldError {
    /// The file cannot be read.
    #[error("it cannot be read: {reason}")]
    Unreadable {
        /// Why.
        reason: String,
    },
    /// A line of a table is wrong.
    #[error("line {line}: {reason}")]
    Line {
        /// Its number, from 1.
        line: usize,
        /// The fault.
        reason: String,
    },
    /// The file is neither a table nor an unstructured grid of VTK XML.
    #[error("{reason}")]
    File {
        /// Why.
        reason: String,
    },
    /// No array of the points has one of the names.
    #[error("the points have no array of {components} components called {wanted}; their arrays are: {known}")]
    NoSuchArray {
        /// The numbers of components that would do.
        components: String,
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
        /// The number.
        value: f64,
    },
}

/// Reads a vector at each point from the bytes of a `.vtu` file.
///
/// * `names`: of the array; the first that is there is read. In the plane a third component is left out.
///
/// # Errors
/// See [`FieldError`].
pub(crate) fn point_vectors<S: Space>(bytes: &[u8], names: &[&str]) -> Result<PointVectors<S>, FieldError> {
    let file = Document::new(bytes)?;
    let mut all = PointVectors::<S>::default();
    for piece in &file.pieces {
        let points = piece.points()?;
        let fits = |array: &&Array| (S::DIM..=VTK_AXES).contains(&array.components);
        let named =
            |name: &&str| piece.arrays.iter().filter(fits).find(|a| a.name.eq_ignore_ascii_case(name));
        let Some(array) = names.iter().find_map(named) else {
            let known: Vec<&str> = piece.arrays.iter().map(|array| array.name.as_str()).collect();
            return Err(FieldError::NoSuchArray {
                components: (S::DIM..=VTK_AXES).map(|n| n.to_string()).collect::<Vec<_>>().join(" or "),
                wanted: names.join(", "),
                known: known.join(", "),
            });
        };
        let expected = [VTK_AXES, array.components].map(|each| piece.count.saturating_mul(each));
        let (places, values) = (file.reals(points, expected[0])?, file.reals(array, expected[1])?);
        if [places.len(), values.len()] != expected {
            let found = format!("{} coordinates and {} values", places.len(), values.len());
            return Err(fault(format!("it has {found} for {} points", piece.count)));
        }
        all.points.extend(places.chunks_exact(VTK_AXES).map(|p| S::Vector::of(|c| p[c])));
        all.values.extend(values.chunks_exact(array.components).map(|v| S::Vector::of(|c| v[c])));
    }
    for of in [&all.points, &all.values] {
        for (point, v) in of.iter().enumerate() {
            if let Some(value) = v.entries().iter().find(|x| !x.is_finite()) {
                return Err(FieldError::NotFinite { point, value: *value });
            }
        }
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vtu::{VtuArray, VtuCells, VtuData, VtuMesh, three, write};
    use base64::Engine;
    use base64::engine::general_purpose::STANDARD;
    use fem_core::geometry::Vector;

    fn read(bytes: &[u8]) -> Result<PointVectors, FieldError> {
        point_vectors(bytes, &["displacement", "u"])
    }

    #[test]
    fn what_is_written_here_is_read_again() {
        let points = vec![Vector::new(0.0, 0.0), Vector::new(1.5, 0.0), Vector::new(0.0, -2.0)];
        let values = vec![Vector::new(1e-3, 2.0), Vector::new(-0.1, 0.2), Vector::new(0.0, 1e30)];
        let mesh = VtuMesh {
            points: points.iter().map(three).collect(),
            cells: VtuCells::Triangles(vec![[0, 1, 2]]),
        };
        let data = VtuData { point: vec![VtuArray::vectors("displacement", &values)], ..VtuData::default() };
        let mut bytes = Vec::new();
        write(&mut bytes, &mesh, &data).unwrap();
        assert_eq!(read(&bytes).unwrap(), PointVectors { points, values, lines: Vec::new() });
        // A file that ends early is refused, wherever.
        for end in (0..bytes.len()).step_by(37) {
            let _ = read(&bytes[..end]);
        }
        assert!(matches!(read(&bytes[..bytes.len() / 2]), Err(FieldError::File { .. })));
    }

    /// A file of two points with text in its arrays.
    fn text(format: &str, attributes: &str, arrays: [&str; 2]) -> String {
        format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\"{attributes}>\
             <UnstructuredGrid><Piece NumberOfPoints=\"2\" NumberOfCells=\"0\"><Points><DataArray type=\"Float64\" \
             NumberOfComponents=\"3\" format=\"{format}\">{}</DataArray></Points><PointData><DataArray type=\"Float64\" Name='u' \
             NumberOfComponents=\"2\" format=\"{format}\">{}</DataArray></PointData></Piece></UnstructuredGrid></VTKFile>",
            arrays[0], arrays[1]
        )
    }

    #[test]
    fn text_and_base64_with_and_without_zlib_are_read() {
        let points = [0.0, 0.0, 0.0, 1.0, 2.0, 0.0];
        let values = [0.5, -0.5, 1e-9, 4.0];
        let expected = PointVectors {
            points: vec![Vector::new(0.0, 0.0), Vector::new(1.0, 2.0)],
            values: vec![Vector::new(0.5, -0.5), Vector::new(1e-9, 4.0)],
            lines: Vec::new(),
        };
        let words = |numbers: &[f64]| numbers.iter().map(|x| format!("{x:e} ")).collect::<String>();
        let ascii = text("ascii", "", [&words(&points), &words(&values)]);
        assert_eq!(read(ascii.as_bytes()).unwrap(), expected);
        let bytes = |numbers: &[f64]| -> Vec<u8> { numbers.iter().flat_map(|x| x.to_le_bytes()).collect() };
        // Sizes and data in one part, or each for itself.
        let plain = |numbers: &[f64], apart: bool| {
            let (data, size) = (bytes(numbers), (8 * numbers.len() as u32).to_le_bytes());
            match apart {
                true => STANDARD.encode(size) + &STANDARD.encode(&data),
                false => STANDARD.encode([&size[..], &data].concat()),
            }
        };
        for apart in [false, true] {
            let file = text("binary", "", [&plain(&points, apart), &plain(&values, apart)]);
            assert_eq!(read(file.as_bytes()).unwrap(), expected);
        }
        let file = text("binary", ZLIB, [&packed(&bytes(&points)), &packed(&bytes(&values))]);
        assert_eq!(read(file.as_bytes()).unwrap(), expected);
        let swapped = |numbers: &[f64]| -> String {
            let data: Vec<u8> = numbers.iter().flat_map(|x| x.to_be_bytes()).collect();
            STANDARD.encode([&(data.len() as u32).to_be_bytes()[..], &data].concat())
        };
        let file = text("binary", "", [&swapped(&points), &swapped(&values)]);
        assert_eq!(read(file.replace("LittleEndian", "BigEndian").as_bytes()).unwrap(), expected);
    }

    const ZLIB: &str = " compressor=\"vtkZLibDataCompressor\"";

    /// One compressed block behind its sizes.
    fn packed(bytes: &[u8]) -> String {
        let data = miniz_oxide::deflate::compress_to_vec_zlib(bytes, 6);
        let sizes = [1u32, 1 << 15, bytes.len() as u32, data.len() as u32];
        let sizes: Vec<u8> = sizes.iter().flat_map(|x| x.to_le_bytes()).collect();
        STANDARD.encode(sizes) + &STANDARD.encode(data)
    }

    #[test]
    fn more_data_than_points_and_counts_that_overflow_are_refused() {
        let file = text("binary", ZLIB, [&packed(&[0; 6 * 8]), &packed(&[0; 1 << 20])]);
        let error = read(file.as_bytes()).unwrap_err().to_string();
        assert!(error.contains("compressed data"), "{error}");
        // Three times this number is 2⁶⁴ + 2.
        let count = format!("NumberOfPoints=\"{}\"", u64::MAX / 3 + 1);
        let file = text("ascii", "", ["0 0", "0 0"]).replace("NumberOfPoints=\"2\"", &count);
        let file = file.replace("NumberOfComponents=\"2\"", "NumberOfComponents=\"3\"");
        let error = read(file.as_bytes()).unwrap_err().to_string();
        assert!(error.contains("2 coordinates and 2 values"), "{error}");
    }

    #[test]
    fn damaged_files_are_refused_without_a_panic() {
        let points = [0.0, 0.0, 0.0, 1.0, 2.0, 0.0];
        let bytes: Vec<u8> = points.iter().flat_map(|x: &f64| x.to_le_bytes()).collect();
        let binary = text("binary", ZLIB, [&packed(&bytes), &packed(&bytes[..32])]);
        let ascii = text("ascii", "", ["0 0 0 1e308 -1e308 0", "1e-320 5e-324 1e308 -1.7e308"]);
        assert!(read(ascii.as_bytes()).is_ok());
        let mut state = 1u64;
        let mut random = move |below: usize| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize % below
        };
        for file in [ascii, binary] {
            for _ in 0..2000 {
                let mut damaged = file.clone().into_bytes();
                for _ in 0..=random(3) {
                    let at = random(damaged.len());
                    match random(3) {
                        0 => damaged[at] = random(256) as u8,
                        1 => damaged.truncate(at.max(1)),
                        _ => {
                            let from = random(damaged.len());
                            damaged[at] = damaged[from];
                        }
                    }
                }
                if let Ok(found) = read(&damaged) {
                    assert_eq!(found.points.len(), found.values.len());
                    assert!(found.points.iter().chain(&found.values).flatten().all(|x| x.is_finite()));
                }
            }
        }
    }

    #[test]
    fn faults_are_named() {
        let fault = |bytes: &str| read(bytes.as_bytes()).unwrap_err().to_string();
        assert!(fault("solid x").contains("not an unstructured grid"));
        let ascii = |values: &str| text("ascii", "", ["0 0 0 1 2 0", values]);
        assert!(fault(&ascii("1 2 3")).contains("6 coordinates and 3 values for 2 points"));
        assert!(fault(&ascii("1 2 3 x")).contains("\"x\" is not a number"));
        assert!(fault(&ascii("1 2 3 inf")).contains("point 1 has the value inf"));
        assert!(fault(&ascii("1 2 3 4").replace("'u'", "'v'")).contains("their arrays are: v"));
        let lzma = text("ascii", " compressor=\"vtkLZMADataCompressor\"", ["", ""]);
        assert!(fault(&lzma).contains("only zlib"));
    }
}
