//! From bytes to a [`MeshFile`]: the file's format is told by its content, not by its name.

use super::{Includes, MeshFault, MeshFile, MeshFileError, MeshPlace, abaqus, first_bytes, gmsh};
use sha2::{Digest, Sha256};
use std::io::Read;
use std::path::Path;

/// The largest mesh file that is read, in bytes, included files counted as well.
pub const LARGEST_MESH_FILE: u64 = 8 << 30;

/// Reads a mesh file from disk, and the files it includes, which are looked for beside it.
///
/// # Errors
/// A file that cannot be read, and everything that makes it no mesh; see [`MeshFileError`].
pub fn read(path: &Path) -> Result<MeshFile, MeshFileError> {
    let name = path.to_string_lossy();
    let unreadable = |why: String| {
        MeshFileError::new(MeshFault::Unreadable, &name, MeshPlace::File, format!("cannot be read: {why}"))
    };
    let mut left = LARGEST_MESH_FILE;
    let bytes = bytes(path, &mut left).map_err(unreadable)?;
    let mut hasher = Sha256::new();
    hasher.update(&bytes);
    let mut include = |from: &Path, file: &str| {
        let path = from.parent().unwrap_or(Path::new("")).join(file);
        let found = self::bytes(&path, &mut left)?;
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
    let mut none = |_: &Path, _: &str| Err("included files are not read here".to_owned());
    let mut mesh = dispatch(bytes, Path::new(name), &mut none)?;
    mesh.digest = Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect();
    Ok(mesh)
}

/// Tells the format by the first bytes that are neither blank nor comment.
fn dispatch(bytes: &[u8], path: &Path, include: Includes<'_>) -> Result<MeshFile, MeshFileError> {
    let name = path.to_string_lossy();
    let fault = |found: String| {
        MeshFileError::new(MeshFault::Format, &name, MeshPlace::File, found)
            .expected("Gmsh's MSH 2.2 or 4.1, or an Abaqus-style input deck (.inp)")
    };
    let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let text = text.trim_ascii_start();
    match text.first() {
        None if bytes.is_empty() => Err(fault("the file is empty".to_owned())),
        None => Err(fault("the file holds nothing but blanks".to_owned())),
        Some(b'$') => gmsh::parse(bytes, &name),
        Some(b'*') => abaqus::parse(bytes, path, include),
        Some(b'<') => {
            let found = format!("the file begins with {}", first_bytes(text));
            Err(fault(found).help("this looks like a web page or XML: download the mesh file itself"))
        }
        Some(_) => Err(fault(format!("the file begins with {}", first_bytes(text)))
            .help("other formats can be converted: meshio convert FILE mesh.msh --output-format gmsh")),
    }
}

/// Reads a regular file whole, as far as it is no larger than what is left.
fn bytes(path: &Path, left: &mut u64) -> Result<Vec<u8>, String> {
    let found = std::fs::metadata(path).map_err(|e| e.to_string())?;
    if found.is_dir() {
        return Err("it is a directory".to_owned());
    }
    if !found.is_file() {
        return Err("it is not a regular file".to_owned());
    }
    let too_large = || format!("it has more than {LARGEST_MESH_FILE} bytes");
    if found.len() > *left {
        return Err(too_large());
    }
    let mut bytes = Vec::new();
    bytes
        .try_reserve_exact(found.len() as usize)
        .map_err(|_| "there is not enough memory for it".to_owned())?;
    let file = std::fs::File::open(path).map_err(|e| e.to_string())?;
    file.take(*left + 1).read_to_end(&mut bytes).map_err(|e| e.to_string())?;
    *left = left.checked_sub(bytes.len() as u64).ok_or_else(too_large)?;
    Ok(bytes)
}
