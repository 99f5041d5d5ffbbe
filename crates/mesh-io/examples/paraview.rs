//! Writes a block with a displacement and a stress, its lower side with a pressure, and a collection of both, into the
//! directory given as the only argument (or `target/paraview`).

use fem_core::geometry::Vector;
use fem_core::mesh::generate::block;
use mesh_io::vtu::{self, PvdEntry, VtuArray, VtuCells, VtuData, VtuMesh};
use std::error::Error;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

fn main() -> Result<(), Box<dyn Error>> {
    let directory =
        std::env::args_os().nth(1).map_or_else(|| PathBuf::from("target/paraview"), PathBuf::from);
    std::fs::create_dir_all(&directory)?;
    write(&directory)
}

fn write(directory: &Path) -> Result<(), Box<dyn Error>> {
    let mesh = block([0.0, 0.0], [2.0, 1.0], [30, 15])?;
    let displaced = |p: &Vector| Vector::new(0.01 * p[0] * p[1], -0.02 * p[1]);
    let displacement: Vec<Vector> = mesh.points().iter().map(displaced).collect();
    let stress: Vec<_> = (0..mesh.cells().len()).map(|t| [1.0, 2.0, 3.0, t as f64, 0.0, 0.5]).collect();
    let area = (0..mesh.cells().len()).map(|t| mesh.measure(t)).collect();
    let body = VtuMesh::from(&mesh);
    let data = VtuData {
        point: vec![VtuArray::vectors("displacement", &displacement)],
        cell: vec![VtuArray::tensors("stress", stress), VtuArray::scalars("area", area)],
        field: vec![VtuArray::scalars("iteration", vec![7.0])],
    };
    save(&directory.join("body.vtu"), &body, &data)?;

    let points: Vec<_> = (0..=30).map(|k| [2.0 * f64::from(k) / 30.0, 0.0, 0.0]).collect();
    let pressure = points.iter().map(|p| 1.0 / (1.0 + p[0])).collect();
    let line = VtuMesh { points, cells: VtuCells::Lines((0..30).map(|k| [k, k + 1]).collect()) };
    let data = VtuData { point: vec![VtuArray::scalars("pressure", pressure)], ..VtuData::default() };
    save(&directory.join("contact.vtu"), &line, &data)?;

    let entry = |part, name: &str| PvdEntry {
        timestep: 0.0,
        part,
        name: name.to_owned(),
        file: format!("{name}.vtu"),
    };
    std::fs::write(directory.join("run.pvd"), vtu::pvd(&[entry(0, "body"), entry(1, "contact")])?)?;
    Ok(())
}

fn save(path: &Path, mesh: &VtuMesh, data: &VtuData) -> Result<(), Box<dyn Error>> {
    let mut file = BufWriter::new(File::create(path)?);
    vtu::write(&mut file, mesh, data)?;
    file.flush()?;
    Ok(())
}

#[test]
fn collection_names_the_files_beside_it() {
    let directory = tempfile::tempdir().unwrap();
    write(directory.path()).unwrap();
    let read = |name: &str| std::fs::read_to_string(directory.path().join(name)).unwrap();
    let collection = read("run.pvd");
    for name in ["body.vtu", "contact.vtu"] {
        assert!(collection.contains(&format!("file=\"{name}\"")), "{collection}");
        assert!(!std::fs::read(directory.path().join(name)).unwrap().is_empty());
    }
}
