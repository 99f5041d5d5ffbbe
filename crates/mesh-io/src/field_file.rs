//! Fields at points from files: tables (`.csv`) and grids (`.vtu`).

use crate::mesh_file::{LARGEST_MESH_FILE, regular_file};
use crate::vtu::{FieldError, PointVectors, point_vectors};
use fem_core::geometry::Coordinates;
use fem_core::space::Space;
use std::path::Path;

/// The columns of a table of displacements in space; those of the plane are the same without z and uz.
pub const FIELD_COLUMNS: [[&str; 2]; 3] = [["x", "ux"], ["y", "uy"], ["z", "uz"]];

/// Reads a vector at each point of a file: of a table with the columns x, y, ux, uy, and in space z, uz, if its name ends with `.csv`, else
/// of a grid of VTK XML.
///
/// * `names`: of the array of a grid; the first that is there is read. In the plane a third component is left out.
///
/// # Errors
/// A file that cannot be read or is no regular file, such as a pipe; see [`FieldError`].
pub fn read_point_vectors<S: Space>(path: &Path, names: &[&str]) -> Result<PointVectors<S>, FieldError> {
    let mut left = LARGEST_MESH_FILE;
    let bytes = regular_file(path, &mut left).map_err(|why| FieldError::Unreadable { reason: why.found })?;
    if path.extension().is_some_and(|end| end.eq_ignore_ascii_case("csv")) {
        let text = std::str::from_utf8(&bytes);
        let text = text.map_err(|_| FieldError::File { reason: "it is not text in UTF-8".into() })?;
        return table(text);
    }
    point_vectors(&bytes, names)
}

/// Reads a table with a head; other columns, in the plane also z and uz, are left out.
fn table<S: Space>(text: &str) -> Result<PointVectors<S>, FieldError> {
    let fault = |line: usize, reason: String| FieldError::Line { line, reason };
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut lines = (1..).zip(text.lines()).filter(|(_, line)| !line.trim().is_empty());
    let Some((first, head)) = lines.next() else {
        return Err(FieldError::File { reason: "the file is empty".into() });
    };
    let names: Vec<String> =
        head.split(',').map(|name| name.trim().trim_matches('"').to_lowercase()).collect();
    // The columns of points, then those of values.
    let mut columns = Vec::with_capacity(2 * S::DIM);
    for wanted in [0, 1].into_iter().flat_map(|of| (0..S::DIM).map(move |c| FIELD_COLUMNS[c][of])) {
        let mut found = (0..names.len()).filter(|k| names[*k] == wanted);
        columns.push(found.next().ok_or_else(|| fault(first, format!("there is no column {wanted}")))?);
        if found.next().is_some() {
            return Err(fault(first, format!("there are two columns {wanted}")));
        }
    }
    let mut read = PointVectors::default();
    for (line, text) in lines {
        let cells: Vec<&str> = text.split(',').collect();
        let mut numbers = vec![0.0; columns.len()];
        for (number, column) in numbers.iter_mut().zip(&columns) {
            let text = cells.get(*column).map_or("", |cell| cell.trim().trim_matches('"'));
            let value = text.parse::<f64>().ok().filter(|value| value.is_finite());
            *number =
                value.ok_or_else(|| fault(line, format!("\"{}\" is not a finite number", brief(text))))?;
        }
        read.points.push(S::Vector::of(|c| numbers[c]));
        read.values.push(S::Vector::of(|c| numbers[S::DIM + c]));
        read.lines.push(line);
    }
    Ok(read)
}

/// Shortens what is quoted.
fn brief(text: &str) -> String {
    text.chars().take(40).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use fem_core::geometry::Vector;
    use fem_core::space::{Plane, Solid};

    #[test]
    fn a_table_names_the_line_of_a_fault() {
        for end in ["\n", "\r\n"] {
            let rows = ["node, X ,\"Y\",ux,uy", "1,0,1,2,3", "", "2,1,1e0, 5,7"].join(end);
            let found = table::<Plane>(&rows).unwrap();
            assert_eq!(found.points, [Vector::new(0.0, 1.0), Vector::new(1.0, 1.0)]);
            assert_eq!(found.values, [Vector::new(2.0, 3.0), Vector::new(5.0, 7.0)]);
            assert_eq!(found.lines, [2, 4]);
            let fault = table::<Plane>(&format!("{rows}{end}{end}3,0,0,0,inf{end}")).unwrap_err().to_string();
            assert_eq!(fault, "line 6: \"inf\" is not a finite number", "{end:?}");
        }
    }

    #[test]
    fn columns_are_found_by_their_names() {
        let found = table::<Plane>("\u{feff}uz,uy,z,y,ux,x\n9,4,8,2,3,1\n").unwrap();
        assert_eq!((found.points, found.values), (vec![Vector::new(1.0, 2.0)], vec![Vector::new(3.0, 4.0)]));
        let said = |text: &str| table::<Plane>(text).unwrap_err().to_string();
        assert_eq!(said("x,y,ux\n"), "line 1: there is no column uy");
        assert_eq!(said("x,y,ux,uy,x\n"), "line 1: there are two columns x");
        assert_eq!(said(" \n"), "the file is empty");
        assert_eq!(said("x,y,ux,uy\n1,2,3\n"), "line 2: \"\" is not a finite number");
        assert_eq!(said("x,y,ux,uy\n1,2,3,1e999\n"), "line 2: \"1e999\" is not a finite number");
    }

    #[test]
    fn a_table_of_a_solid_has_six_columns() {
        let found = table::<Solid>("uz,uy,z,y,ux,x\n9,4,8,2,3,1\n").unwrap();
        assert_eq!((found.points[0], found.values[0]), ([1.0, 2.0, 8.0].into(), [3.0, 4.0, 9.0].into()));
        let said = |text: &str| table::<Solid>(text).unwrap_err().to_string();
        assert_eq!(said("x,y,ux,uy\n1,2,3,4\n"), "line 1: there is no column z");
        assert_eq!(said("x,y,z,ux,uy\n"), "line 1: there is no column uz");
    }

    #[test]
    fn directories_and_devices_are_refused_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let said = |path: &Path| read_point_vectors::<Plane>(path, &["u"]).unwrap_err().to_string();
        assert_eq!(said(folder.path()), "it cannot be read: it is a directory");
        if cfg!(unix) {
            assert_eq!(said(Path::new("/dev/zero")), "it cannot be read: it is not a regular file");
        }
        assert!(said(&folder.path().join("none.csv")).starts_with("it cannot be read: "));
    }
}
