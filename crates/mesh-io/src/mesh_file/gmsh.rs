//! Gmsh's mesh files: MSH 1, 2.0, 2.1, 2.2, 4.0 and 4.1, as text or in binary of either byte order.
//!
//! The format is described in Gmsh's reference manual, chapter "Gmsh file formats" (MSH 4.1), and its section on
//! legacy formats (MSH 2), <https://gmsh.info/doc/texinfo/gmsh.html>. What is read: `$PhysicalNames`, `$Entities`,
//! `$PartitionedEntities`, `$Nodes`, `$Elements`; other sections are skipped. What must be known about it:
//!
//! - A physical group is a dimension and a number; names are unique per dimension only, so one name may mean edges
//!   and cells at once. A group without a name is called by its number.
//! - In 2.2 an element carries its group, and one that lies in several groups is written several times. In 4.1 the
//!   geometric entity carries the groups, any number of them.
//! - In 2.0 names of groups may have no dimension: such a name belongs to every group of its number.
//! - Signs of group numbers tell the sense of a curve. They are ignored here: outward normals come from the cells.
//! - As soon as one group exists, Gmsh saves only what lies in a group. Without any the elementary entities take their place, called by number.
//!
//! # Example
//! ```
//! let text = b"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n2 7 \"plate\"\n$EndPhysicalNames\n\
//!     $Nodes\n3\n1 0 0 0\n2 1 0 0\n9 0 1 0\n$EndNodes\n$Elements\n1\n1 2 2 7 1 1 2 9\n$EndElements\n";
//! let file = mesh_io::gmsh::parse(text, "plate.msh")?;
//! assert_eq!(file.group_names(2).collect::<Vec<_>>(), ["plate"]);
//! # Ok::<(), mesh_io::MeshFileError>(())
//! ```

mod elements;
mod labels;
mod msh1;
mod msh2;
mod msh4;
mod values;

#[cfg(test)]
mod tests;

use crate::mesh_file::{Collector, MeshFile, MeshFileError};
use labels::Labels;
use values::{Mode, Values, shown};

/// How Gmsh itself converts a file; shown when a version is not read.
const CONVERT: &str = "convert it with Gmsh: gmsh old.msh -save -format msh41 -o new.msh";

/// The versions that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Version {
    One,
    /// 2.0 to 2.2.
    Two,
    /// 4.0.
    OldFour,
    /// 4.1.
    Four,
}

impl Version {
    /// Says whether entities carry the groups.
    fn has_entities(self) -> bool {
        matches!(self, Self::OldFour | Self::Four)
    }
}

/// A file while it is read, and what was read.
struct Contents<'a> {
    v: Values<'a>,
    collector: Collector,
    labels: Labels,
}

/// Reads a mesh from the bytes of a `.msh` file.
///
/// * `name`: what messages call it.
///
/// # Errors
/// Other versions by name, and everything that makes it no mesh, with its place.
pub fn parse(bytes: &[u8], name: &str) -> Result<MeshFile, MeshFileError> {
    let mut v = Values::new(bytes, name);
    let (version, number) = header(&mut v)?;
    let mut file = Contents { v, collector: Collector::new(name), labels: Labels::default() };
    let (mut nodes, mut elements) = (false, false);
    let old = version == Version::OldFour;
    if version == Version::One {
        // Its head is the first line of this section.
        file.v.enter("$NOD");
        nodes = true;
        msh2::nodes(&mut file, "$ENDNOD")?;
    }
    while file.v.skip_blank() {
        let section = file.v.token()?;
        if version.has_entities() && file.v.is_binary() && section != b"$PhysicalNames" {
            // The numbers begin right behind the line.
            file.v.rest_of_line();
        }
        match section {
            b"$PhysicalNames" => file.labels.read_names(&mut file.v)?,
            b"$Entities" if version.has_entities() => msh4::entities(&mut file, false, old)?,
            b"$PartitionedEntities" if version.has_entities() => {
                msh4::entities(&mut file, true, old)?;
            }
            b"$ELM" if version == Version::One => {
                once(&file.v, &mut elements, "$ELM")?;
                msh1::elements(&mut file)?;
            }
            b"$Nodes" => {
                once(&file.v, &mut nodes, "$Nodes")?;
                match version {
                    Version::One | Version::Two => msh2::nodes(&mut file, "$EndNodes")?,
                    Version::OldFour | Version::Four => msh4::nodes(&mut file, old)?,
                }
            }
            b"$Elements" => {
                once(&file.v, &mut elements, "$Elements")?;
                match version {
                    Version::One | Version::Two => msh2::elements(&mut file)?,
                    Version::OldFour | Version::Four => msh4::elements(&mut file, old)?,
                }
            }
            _ => skip(&mut file.v, section)?,
        }
    }
    for (there, section) in [(nodes, "$Nodes"), (elements, "$Elements")] {
        if !there {
            file.v.enter("the file");
            return Err(file
                .v
                .fault(format!("the file ends without a section {section}"))
                .expected("a complete mesh; the file may have been cut while it was copied"));
        }
    }
    let encoding = match file.v.mode {
        Mode::Ascii => "text",
        Mode::BinaryLittle => "binary",
        Mode::BinaryBig => "binary, big-endian",
    };
    let mut collected = file.collector.finish(format!("Gmsh MSH {number}, {encoding}"))?;
    file.labels.apply(&mut collected)?;
    Ok(collected.mesh)
}

/// Refuses a duplicate section.
fn once(v: &Values<'_>, seen: &mut bool, section: &str) -> Result<(), MeshFileError> {
    if std::mem::replace(seen, true) {
        return Err(v.fault(format!("there is a second section {section}")).expected("one"));
    }
    Ok(())
}

/// Skips a section that is not needed.
fn skip(v: &mut Values<'_>, section: &[u8]) -> Result<(), MeshFileError> {
    let Some(name) = section.strip_prefix(b"$") else {
        let found = format!("found {} between two sections", shown(section));
        return Err(v.fault(found).expected("a section such as `$Nodes`"));
    };
    v.enter("a section that is not needed");
    let end = [b"$End", name].concat();
    if v.skip_past(&end) { Ok(()) } else { Err(v.ended()) }
}

/// Reads `$MeshFormat`, which must come first (but for comments).
fn header(v: &mut Values<'_>) -> Result<(Version, &'static str), MeshFileError> {
    let mut section = v.token()?;
    while section == b"$Comments" {
        skip(v, section)?;
        section = v.token()?;
    }
    match section {
        b"$MeshFormat" => {}
        b"$NOD" => return Ok((Version::One, "1")),
        other => {
            let found = format!("the file begins with {}", shown(other));
            return Err(v.unsupported(found).expected("`$MeshFormat`, with which MSH files begin"));
        }
    }
    v.enter("$MeshFormat");
    let version = v.token()?;
    let number: Option<f64> = std::str::from_utf8(version).ok().and_then(|t| t.parse().ok());
    let is = |wanted: f64| number.is_some_and(|n| (n - wanted).abs() < 1e-9);
    let all = [
        (2.0, Version::Two, "2.0"),
        (2.1, Version::Two, "2.1"),
        (2.2, Version::Two, "2.2"),
        (4.0, Version::OldFour, "4.0"),
        (4.1, Version::Four, "4.1"),
    ];
    let Some((_, known, text)) = all.into_iter().find(|(wanted, ..)| is(*wanted)) else {
        let named = number.filter(|n| (0.0..100.0).contains(n)).map(|n| format!("{n:.1}"));
        let found = format!("this is MSH version {}", named.unwrap_or_else(|| shown(version)));
        return Err(v.unsupported(found).expected("1, 2.0, 2.1, 2.2, 4.0 or 4.1").help(CONVERT));
    };
    let kind = v.int("0 for text or 1 for binary")?;
    let size = v.int("8, the size of a number")?;
    if size != 8 {
        let found = format!("the file's numbers have {size} bytes");
        return Err(v.unsupported(found).expected("8").help(CONVERT));
    }
    match kind {
        0 => {}
        1 => {
            v.rest_of_line();
            v.mode = Mode::BinaryLittle;
            v.mode = match v.int("the number one")?.to_le_bytes() {
                [1, 0, 0, 0] => Mode::BinaryLittle,
                [0, 0, 0, 1] => Mode::BinaryBig,
                other => {
                    let found = format!("the mark of the byte order is {}", i32::from_le_bytes(other));
                    return Err(v
                        .unsupported(found)
                        .expected("the number one in either order")
                        .help(CONVERT));
                }
            };
        }
        other => {
            return Err(v
                .unsupported(format!("the file type is {other}"))
                .expected("0 (text) or 1 (binary)"));
        }
    }
    v.end("$EndMeshFormat")?;
    Ok((known, text))
}
