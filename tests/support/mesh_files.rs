//! Writes meshes as files of every format that `case-io` reads, so that reading can be compared with what was meant.
//!
//! Several bodies go into one file: region `NAME`, its sides `NAME.SIDE`. Nodes and cells keep their order, so what
//! comes back must be equal bit for bit. Formats: Gmsh's reference manual, chapter "Gmsh file formats".

use crate::model::{NodeId, TriMesh};
use std::fmt::Write as _;

/// The formats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// MSH 2.2.
    Msh2(Encoding),
    /// MSH 4.1.
    Msh4(Encoding),
    /// An Abaqus-style deck of triangles, its sides as surfaces.
    Deck,
    /// The same with two successive triangles joined to a quadrilateral.
    QuadDeck,
}

/// How numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// As text that gives back the same bits.
    Text,
    /// In binary, the low byte first.
    Little,
    /// In binary, the high byte first.
    Big,
}

/// Every format.
pub const ALL: [Format; 8] = [
    Format::Msh2(Encoding::Text),
    Format::Msh2(Encoding::Little),
    Format::Msh2(Encoding::Big),
    Format::Msh4(Encoding::Text),
    Format::Msh4(Encoding::Little),
    Format::Msh4(Encoding::Big),
    Format::Deck,
    Format::QuadDeck,
];

impl Format {
    /// Returns the ending of file names.
    pub fn ending(self) -> &'static str {
        match self {
            Self::Msh2(_) | Self::Msh4(_) => "msh",
            Self::Deck | Self::QuadDeck => "inp",
        }
    }
}

/// A group of elements of one kind: a side or a region.
struct Block {
    dimension: i32,
    tag: i32,
    name: String,
    elements: Vec<Vec<u64>>,
}

/// Writes bodies, each with its name, into one file.
pub fn write(bodies: &[(&str, &TriMesh)], format: Format) -> Vec<u8> {
    match format {
        Format::Deck => deck(bodies, false),
        Format::QuadDeck => deck(bodies, true),
        Format::Msh2(encoding) => msh(bodies, encoding, false),
        Format::Msh4(encoding) => msh(bodies, encoding, true),
    }
}

fn points(bodies: &[(&str, &TriMesh)]) -> Vec<[f64; 2]> {
    bodies.iter().flat_map(|(_, mesh)| mesh.points()).map(|x| (*x).into()).collect()
}

/// Sides first, then regions, as Gmsh orders elements.
fn blocks(bodies: &[(&str, &TriMesh)]) -> Vec<Block> {
    let (mut sides, mut regions) = (Vec::new(), Vec::new());
    let mut first = 1u64;
    for (name, mesh) in bodies {
        let number = |n: &NodeId| n.index() as u64 + first;
        for (side, edges) in mesh.groups() {
            let elements = edges.iter().map(|e| mesh.topology().facets()[*e].iter().map(number).collect());
            let tag = sides.len() as i32 + 1;
            sides.push(Block {
                dimension: 1,
                tag,
                name: format!("{name}.{side}"),
                elements: elements.collect(),
            });
        }
        let elements = mesh.cells().iter().map(|t| t.iter().map(number).collect()).collect();
        regions.push(Block {
            dimension: 2,
            tag: regions.len() as i32 + 1,
            name: (*name).to_owned(),
            elements,
        });
        first += mesh.points().len() as u64;
    }
    sides.extend(regions);
    sides
}

/// Numbers in one encoding.
struct Out {
    bytes: Vec<u8>,
    encoding: Encoding,
}

impl Out {
    fn text(&mut self, text: &str) {
        self.bytes.extend(text.as_bytes());
    }

    fn put(&mut self, text: String, little: &[u8], big: &[u8]) {
        match self.encoding {
            Encoding::Text => self.text(&(text + " ")),
            Encoding::Little => self.bytes.extend(little),
            Encoding::Big => self.bytes.extend(big),
        }
    }

    fn int(&mut self, value: i32) {
        self.put(value.to_string(), &value.to_le_bytes(), &value.to_be_bytes());
    }

    fn size(&mut self, value: u64) {
        self.put(value.to_string(), &value.to_le_bytes(), &value.to_be_bytes());
    }

    fn real(&mut self, value: f64) {
        self.put(format!("{value:?}"), &value.to_le_bytes(), &value.to_be_bytes());
    }

    /// Ends a line of numbers, which binary files do not have.
    fn line(&mut self) {
        if self.encoding == Encoding::Text {
            self.bytes.pop();
            self.bytes.push(b'\n');
        }
    }

    fn end(&mut self, word: &str) {
        if self.encoding != Encoding::Text {
            self.bytes.push(b'\n');
        }
        self.text(word);
    }
}

fn msh(bodies: &[(&str, &TriMesh)], encoding: Encoding, four: bool) -> Vec<u8> {
    let (points, blocks) = (points(bodies), blocks(bodies));
    let mut out = Out { bytes: Vec::new(), encoding };
    let version = if four { "4.1" } else { "2.2" };
    out.text(&format!("$MeshFormat\n{version} {} 8\n", i32::from(encoding != Encoding::Text)));
    if encoding != Encoding::Text {
        out.int(1);
        out.text("\n");
    }
    out.text(&format!("$EndMeshFormat\n$PhysicalNames\n{}\n", blocks.len()));
    for b in &blocks {
        out.text(&format!("{} {} \"{}\"\n", b.dimension, b.tag, b.name));
    }
    out.text("$EndPhysicalNames\n");
    if four {
        msh4(&mut out, &points, &blocks);
    } else {
        msh2(&mut out, &points, &blocks);
    }
    out.bytes
}

fn msh2(out: &mut Out, points: &[[f64; 2]], blocks: &[Block]) {
    out.text(&format!("$Nodes\n{}\n", points.len()));
    for (number, [x, y]) in (1..).zip(points) {
        out.int(number);
        for value in [*x, *y, 0.0] {
            out.real(value);
        }
        out.line();
    }
    out.end("$EndNodes\n");
    let total: usize = blocks.iter().map(|b| b.elements.len()).sum();
    out.text(&format!("$Elements\n{total}\n"));
    let mut number = 0;
    for block in blocks {
        if out.encoding != Encoding::Text {
            for value in [block.dimension, block.elements.len() as i32, 2] {
                out.int(value);
            }
        }
        for nodes in &block.elements {
            number += 1;
            out.int(number);
            if out.encoding == Encoding::Text {
                out.int(block.dimension);
                out.int(2);
            }
            out.int(block.tag);
            out.int(block.tag);
            for node in nodes {
                out.int(*node as i32);
            }
            out.line();
        }
    }
    out.end("$EndElements\n");
}

fn msh4(out: &mut Out, points: &[[f64; 2]], blocks: &[Block]) {
    out.text("$Entities\n");
    let of = |dimension| blocks.iter().filter(move |b| b.dimension == dimension);
    for count in [0, of(1).count(), of(2).count(), 0] {
        out.size(count as u64);
    }
    out.line();
    for block in blocks {
        out.int(block.tag);
        for _ in 0..6 {
            out.real(0.0);
        }
        out.size(1);
        // Gmsh writes the sign of a curve's sense.
        out.int(if block.tag % 2 == 0 { -block.tag } else { block.tag });
        out.size(0);
        out.line();
    }
    out.end("$EndEntities\n$Nodes\n");
    let nodes = points.len() as u64;
    for value in [1, nodes, 1, nodes] {
        out.size(value);
    }
    out.line();
    for value in [2, 1, 0] {
        out.int(value);
    }
    out.size(nodes);
    out.line();
    for number in 1..=nodes {
        out.size(number);
        out.line();
    }
    for [x, y] in points {
        for value in [*x, *y, 0.0] {
            out.real(value);
        }
        out.line();
    }
    out.end("$EndNodes\n$Elements\n");
    let total: usize = blocks.iter().map(|b| b.elements.len()).sum();
    for value in [blocks.len(), total, 1, total] {
        out.size(value as u64);
    }
    out.line();
    let mut number = 0;
    for block in blocks {
        for value in [block.dimension, block.tag, block.dimension] {
            out.int(value);
        }
        out.size(block.elements.len() as u64);
        out.line();
        for nodes in &block.elements {
            number += 1;
            out.size(number);
            for node in nodes {
                out.size(*node);
            }
            out.line();
        }
    }
    out.end("$EndElements\n");
}

/// Writes the nodes of a deck, which may be in a file of their own.
pub fn deck_nodes(bodies: &[(&str, &TriMesh)]) -> String {
    let mut text = "*NODE\n".to_owned();
    for (number, [x, y]) in (1..).zip(points(bodies)) {
        let _ = writeln!(text, "{number}, {x:?}, {y:?}");
    }
    text
}

/// Writes elements and surfaces of a deck.
pub fn deck_elements(bodies: &[(&str, &TriMesh)], quads: bool) -> String {
    let mut text = String::new();
    let (mut first_node, mut first_cell) = (1u64, 1u64);
    for (name, mesh) in bodies {
        let _ = writeln!(text, "*ELEMENT, TYPE={}, ELSET={name}", if quads { "CPE4" } else { "CPE3" });
        let t = mesh.cells();
        let cells: Vec<Vec<NodeId>> = if quads {
            t.chunks(2).map(|pair| vec![pair[0][0], pair[0][1], pair[0][2], pair[1][2]]).collect()
        } else {
            t.iter().map(|t| t.to_vec()).collect()
        };
        for (number, cell) in (first_cell..).zip(&cells) {
            let nodes: Vec<String> =
                cell.iter().map(|n| (n.index() as u64 + first_node).to_string()).collect();
            let _ = writeln!(text, "{number}, {}", nodes.join(", "));
        }
        for (side, edges) in mesh.groups() {
            let _ = writeln!(text, "*SURFACE, TYPE=ELEMENT, NAME={name}.{side}");
            for edge in edges {
                let [a, b] = mesh.topology().facets()[*edge];
                let face = |cell: &Vec<NodeId>| {
                    (0..cell.len()).find(|k| {
                        let ends = [cell[*k], cell[(k + 1) % cell.len()]];
                        ends == [a, b] || ends == [b, a]
                    })
                };
                let found = cells.iter().enumerate().find_map(|(c, cell)| Some((c, face(cell)?)));
                if let Some((cell, face)) = found {
                    let _ = writeln!(text, "{}, S{}", first_cell + cell as u64, face + 1);
                }
            }
        }
        first_node += mesh.points().len() as u64;
        first_cell += cells.len() as u64;
    }
    text
}

fn deck(bodies: &[(&str, &TriMesh)], quads: bool) -> Vec<u8> {
    format!("*HEADING\nWritten for tests.\n{}{}", deck_nodes(bodies), deck_elements(bodies, quads))
        .into_bytes()
}
