//! From bytes to a [`MeshFile`]: the file's format is recognised by its content, not by its name.

use super::{
    Includes, MeshFault, MeshFile, MeshFileError, MeshPlace, abaqus, exodus, first_bytes, gmsh, vtk,
};
use crate::links::BrokenLink;
use sha2::{Digest, Sha256};
use std::io::{self, Read};
use std::path::Path;

/// The largest mesh file that is read, in bytes, included files counted as well.
pub const LARGEST_MESH_FILE: u64 = 8 << 30;

/// Bytes within which a file of VTK XML says what it is.
const HEAD: usize = 1000;

/// Reads a mesh file from disk, and the files it includes, which are looked for beside it.
///
/// # Errors
/// A file that cannot be read, and everything that makes it no mesh; see [`MeshFileError`].
pub fn read(path: &Path) -> Result<MeshFile, MeshFileError> {
    let name = path.to_string_lossy();
    let unreadable = |why: Unreadable| {
        let found = format!("cannot be read: {}", why.found);
        let error = MeshFileError::new(MeshFault::Unreadable, &name, MeshPlace::File, found);
        why.fix.into_iter().fold(error, MeshFileError::help)
    };
    let mut left = LARGEST_MESH_FILE;
    let bytes = regular_file(path, &mut left).map_err(unreadable)?;
    let mut hasher = Sha256::new();
    hasher.update(&bytes);
    let mut include = |from: &Path, file: &str| {
        let path = from.parent().unwrap_or(Path::new("")).join(file);
        let found = regular_file(&path, &mut left)?;
        // The length keeps two files from being taken for one.
        hasher.update((found.len() as u64).to_le_bytes());
        hasher.update(&found);
        Ok((path, found))
    };
    let mut mesh = dispatch(&bytes, path, &mut include)?;
    mesh.digest = hasher.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
    Ok(mesh)
}

/// Reads a mesh file from its bytes; it cannot include others.
///
/// * `name`: what messages call it.
///
/// # Errors
/// Everything that makes it no mesh; see [`MeshFileError`].
pub fn parse(bytes: &[u8], name: &str) -> Result<MeshFile, MeshFileError> {
    let mut none = |_: &Path, _: &str| Err(Unreadable::no_includes());
    let mut mesh = dispatch(bytes, Path::new(name), &mut none)?;
    mesh.digest = Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect();
    Ok(mesh)
}

/// Tells the format by the first bytes that are neither blank nor comment.
fn dispatch(bytes: &[u8], path: &Path, include: Includes<'_>) -> Result<MeshFile, MeshFileError> {
    let name = path.to_string_lossy();
    let fault = |found: String| {
        MeshFileError::new(MeshFault::Format, &name, MeshPlace::File, found)
            .expected("Gmsh's MSH 1, 2 or 4, an Abaqus-style input deck (.inp), Exodus II (.e, .exo, .g), or a grid of VTK XML (.vtu)")
    };
    let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let text = text.trim_ascii_start();
    match text.first() {
        None if bytes.is_empty() => Err(fault("the file is empty".to_owned())),
        None => Err(fault("the file holds nothing but blanks".to_owned())),
        Some(b'$') => gmsh::parse(bytes, &name),
        Some(b'*') => abaqus::parse(bytes, path, include),
        Some(_) if text.starts_with(abaqus::QUOTED_COMMENT) => abaqus::parse(bytes, path, include),
        Some(_) if bytes.starts_with(exodus::CLASSIC) => exodus::parse(bytes, &name),
        Some(_) if bytes.starts_with(exodus::HDF5) => {
            let error = fault("this is an HDF5 file, as netCDF-4 is".to_owned());
            Err(error.help(
                "of an Exodus file: nccopy -k classic FILE new.e (nccopy -k cdf5 if it has 64-bit integers)",
            ))
        }
        Some(b'<') if text[..text.len().min(HEAD)].windows(7).any(|word| word == b"VTKFile") => {
            vtk::parse(bytes, &name)
        }
        Some(b'<') => {
            let found = format!("the file begins with {}", first_bytes(text));
            Err(fault(found).help("this looks like a web page or XML: download the mesh file itself"))
        }
        Some(_) => Err(fault(format!("the file begins with {}", first_bytes(text))).help(conversion(text))),
    }
}

/// Says how a file of another program is converted; several of them have the endings `.msh` and `.inp` too.
fn conversion(text: &[u8]) -> &'static str {
    let mut lines = text.split(|b| *b == b'\n').map(<[u8]>::trim_ascii);
    let first = lines.find(|line| !line.is_empty() && !line.starts_with(b"#")).unwrap_or_default();
    let words = || first.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    let whole = words().all(|word| word.iter().all(u8::is_ascii_digit));
    match words().count() {
        5 if whole => {
            "this looks like AVS UCD: meshio convert --input-format avsucd FILE mesh.msh --output-format gmsh22"
        }
        3 if whole => {
            "this looks like a mesh of FreeFem: load \"iovtk\"; savevtk(\"mesh.vtu\", Th); and then \
             meshio convert mesh.vtu mesh.msh --output-format gmsh22"
        }
        _ if first.get(..4).is_some_and(|word| word.eq_ignore_ascii_case(b"MESH")) => {
            "this looks like a mesh of GiD: as a deck, write *NODE in place of Coordinates, *ELEMENT, TYPE=CPS3 (or \
             the like) in place of Elements, and commas between the numbers"
        }
        _ => "other formats can be converted: meshio convert FILE mesh.msh --output-format gmsh22",
    }
}

/// Why a file cannot be read, and a fix that is better than to check its name.
pub(crate) struct Unreadable {
    pub(crate) found: String,
    pub(crate) fix: Option<&'static str>,
}

impl Unreadable {
    fn new(found: impl Into<String>, fix: Option<&'static str>) -> Self {
        Self { found: found.into(), fix }
    }

    /// A deck that is given as bytes alone.
    pub(crate) fn no_includes() -> Self {
        Self::new("included files are not read here", None)
    }

    fn of_system(path: &Path, error: &io::Error) -> Self {
        if let Some(link) = BrokenLink::find(path) {
            return Self::new(format!("it {link}"), Some(BrokenLink::FIX));
        }
        let fix = (error.kind() == io::ErrorKind::PermissionDenied).then_some("allow this user to read it");
        Self::new(error.to_string(), fix)
    }
}

/// Reads a regular file whole, as far as it is no larger than what is left.
pub(crate) fn regular_file(path: &Path, left: &mut u64) -> Result<Vec<u8>, Unreadable> {
    let of_system = |error: std::io::Error| Unreadable::of_system(path, &error);
    let found = std::fs::metadata(path).map_err(of_system)?;
    if found.is_dir() {
        return Err(Unreadable::new("it is a directory", Some("name the mesh file in it")));
    }
    if !found.is_file() {
        return Err(Unreadable::new("it is not a regular file", None));
    }
    let too_large =
        || Unreadable::new(format!("it has more than {LARGEST_MESH_FILE} bytes"), Some("mesh it coarser"));
    if found.len() > *left {
        return Err(too_large());
    }
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(found.len() as usize).map_err(|_| {
        Unreadable::new("there is not enough memory for it", Some("mesh it coarser, or free memory"))
    })?;
    let file = std::fs::File::open(path).map_err(of_system)?;
    file.take(*left + 1).read_to_end(&mut bytes).map_err(of_system)?;
    *left = left.checked_sub(bytes.len() as u64).ok_or_else(too_large)?;
    Ok(bytes)
}
