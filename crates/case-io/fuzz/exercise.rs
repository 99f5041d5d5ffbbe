//! Reads hostile bytes with every parser: shared by the fuzz targets and by the test that replays their finds.

use case_io::case::Dimension;
use case_io::case_file::split_override;
use case_io::diagnostic::Diagnostic;
use case_io::{Case, Expression};
use fem_core::space::{Plane, Solid};
use mesh_io::{MeshFile, MeshFileError, RegionOptions, abaqus, exodus, gmsh, vtk};
use peak_alloc::PeakAlloc;

/// Bytes of memory that may be used per byte of input.
const PER_BYTE: usize = 100;
/// And beside that: tables of keys, a mesh of [`MOST_NODES`] nodes, messages.
const CONSTANT: usize = 2 << 20;
/// Bodies of generated meshes are made up to this many nodes: their size is the user's wish, not a flaw.
const MOST_NODES: u64 = 400;
/// Groups of one file that are taken as regions: all of them would be quadratic work, and none of the reader's doing.
const MOST_REGIONS: usize = 8;

/// Runs a target and demands that its memory stays within a multiple of the size of the input.
pub fn bounded(memory: &PeakAlloc, target: fn(&[u8]), bytes: &[u8]) {
    memory.reset_peak_usage();
    let before = memory.current_usage();
    target(bytes);
    let used = memory.peak_usage().saturating_sub(before);
    let allowed = PER_BYTE * bytes.len() + CONSTANT;
    assert!(used <= allowed, "{used} bytes of memory for an input of {} bytes", bytes.len());
}

/// Reads a case file; a sound one is written out, named, warned about and built.
pub fn case(bytes: &[u8]) {
    let case = match Case::parse_bytes(bytes, "case.toml", &[]) {
        Ok(case) => case,
        Err(error) => {
            assert!(!error.diagnostics.is_empty());
            drop(error.to_string());
            return;
        }
    };
    drop(case.settings_json().to_string());
    assert_eq!(case.hash().len(), 64);
    drop(case.warnings());
    drop(case.output_directory());
    if case.node_counts().iter().sum::<u64>() > MOST_NODES {
        return;
    }
    // Bodies of mesh files end in an error: no file is read here.
    if let Err(error) = case.build() {
        assert!(!error.diagnostics.is_empty());
        drop(error.to_string());
    }
}

/// Reads a Gmsh file and all that is made of it.
pub fn msh(bytes: &[u8]) {
    mesh(gmsh::parse(bytes, "mesh.msh"));
}

/// Reads a deck and all that is made of it.
pub fn inp(bytes: &[u8]) {
    mesh(abaqus::parse_text(bytes, "mesh.inp"));
}

/// Reads an Exodus file and all that is made of it.
pub fn exo(bytes: &[u8]) {
    mesh(exodus::parse(bytes, "mesh.e"));
}

/// Reads a grid of VTK XML and all that is made of it.
pub fn vtu(bytes: &[u8]) {
    mesh(vtk::parse(bytes, "mesh.vtu"));
}

fn mesh(read: Result<MeshFile, MeshFileError>) {
    let refused = |error: MeshFileError| drop(Diagnostic::of_mesh_file(error, None).to_string());
    let file = match read {
        Ok(file) => file,
        Err(error) => return refused(error),
    };
    drop(file.summary());
    regions::<Plane>(&file);
    regions::<Solid>(&file);
}

fn regions<S: Dimension>(file: &MeshFile) {
    let refused = |error: MeshFileError| drop(Diagnostic::of_mesh_file(error, None).to_string());
    let groups = file.group_names(S::DIM as u8).take(MOST_REGIONS).map(|name| vec![name]);
    for names in std::iter::once(Vec::new()).chain(groups) {
        for merge in [false, true] {
            match S::region(file, &names, RegionOptions::with_merge(merge)) {
                Ok(region) => match region.mesh() {
                    Ok(mesh) => assert!((0..mesh.cells().len()).all(|t| mesh.measure(t) > 0.0)),
                    Err(error) => refused(error),
                },
                Err(error) => refused(error),
            }
        }
    }
}

/// Reads an expression and evaluates it; the same text is tried as an override of the command line.
pub fn expression(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    drop(split_override(text));
    match Expression::parse(text) {
        Ok(expression) => {
            for point in [[0.0, 0.0], [1.5, -2.0], [f64::MAX, f64::MIN_POSITIVE], [f64::NAN, f64::INFINITY]] {
                let value = expression.at(point);
                assert_eq!(value.to_bits(), expression.at(point).to_bits());
            }
            if expression.is_constant() {
                assert_eq!(expression.at([0.0, 0.0]).to_bits(), expression.at([1.0, 2.0]).to_bits());
            }
        }
        Err(error) => {
            // The place lies in the text, on the borders of characters.
            assert!(text.get(error.span.clone()).is_some(), "{:?} of {text:?}", error.span);
            assert!(!error.message.is_empty());
        }
    }
}
