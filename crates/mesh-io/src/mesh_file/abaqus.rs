//! Input decks in the manner of Abaqus (`.inp`), as CalculiX, PrePoMax, Cubit and Gmsh write them too: the mesh of one.
//!
//! The format follows the keyword reference of the CalculiX manual, <https://www.dhondt.de>, chapter "Input deck
//! format", which is Abaqus's as far as it goes. What is read: `*NODE`, `*ELEMENT` of plane kinds (`CPS`, `CPE`,
//! `M3D`, `S` with 3, 4, 6, 8 or 9 nodes), of volumes (`C3D` with 4, 5, 6, 8, 10, 13, 15, 20 or 27 nodes) and of lines (`T2D`, `T3D`, `B2`, `B3`), `*NSET` and `*ELSET` with
//! `GENERATE`, `*SURFACE` of elements (`S1` … `S6`) and of nodes, `*INCLUDE`. Keywords and set names may be written in
//! any case; a keyword line that ends with a comma continues in the next one; lines with `**` are comments.
//!
//! - Parts are read once for each `*INSTANCE` of the `*ASSEMBLY`, at its place. All cells of an instance are a region of its name; a set
//!   or surface `top` of its part is `instance.top`, one of the assembly keeps its name.
//! - A set of cells is a region. A surface, a set of line elements or, failing those, a set of nodes is a group of
//!   edges; a set of nodes means the free edges whose both ends are in it.
//! - Keywords that make or move nodes and elements are refused by name, because leaving them out would change the
//!   mesh. All others are ignored and counted: supports, loads and materials are not part of a mesh.
//! - A deck has no end mark, so one that was cut at the end of a line cannot be distinguished from a shorter one.
//!
//! # Example
//! ```
//! let text = b"*node\n1, 0., 0.\n2, 1., 0.\n9, 0., 1.\n*Element, type=CPS3, elset=plate\n1, 1, 2, 9\n\
//!     *Surface, type=ELEMENT, name=base\nplate, S1\n";
//! let file = mesh_io::abaqus::parse_text(text, "plate.inp")?;
//! assert_eq!(file.group_names(2).collect::<Vec<_>>(), ["plate"]);
//! assert_eq!(file.group_names(1).collect::<Vec<_>>(), ["base"]);
//! # Ok::<(), mesh_io::MeshFileError>(())
//! ```

mod data;
mod deck;
mod entries;
mod keyword;
mod sets;

#[cfg(test)]
mod tests;

use crate::mesh_file::{Includes, MeshFile, MeshFileError, Unreadable};
use deck::Deck;
use std::path::Path;

/// A comment with a mark in front of it, as some decks of CalculiX have it.
pub(super) const QUOTED_COMMENT: &[u8] = b">**";

/// Reads a mesh from the text of a deck that includes no other file.
///
/// * `name`: what messages call it.
///
/// # Errors
/// Keywords that cannot be left out, and everything that makes it no mesh, with its place.
pub fn parse_text(text: &[u8], name: &str) -> Result<MeshFile, MeshFileError> {
    parse(text, Path::new(name), &mut |_, _| Err(Unreadable::no_includes()))
}

/// Reads a mesh from the text of a deck; `include` reads the files it includes.
pub(crate) fn parse(text: &[u8], path: &Path, include: Includes<'_>) -> Result<MeshFile, MeshFileError> {
    let mut deck = Deck::new(&path.to_string_lossy());
    deck.read(text, path, 0, include)?;
    deck.finish()
}
