//! The lines of a deck: comments, keywords with their continuations, included files, and the block data lines go to.

mod instances;

use super::data::{self, DataLine};
use super::entries::{set_entries, surface_entry};
use super::keyword::{Keyword, upper};
use super::sets::{Sets, Surface};
use crate::mesh_file::{Collector, ElementKind, Includes, MeshFault, MeshFile, MeshFileError, Spot};
use crate::words::counted;
use instances::{Frame, Motion, Part};
use std::collections::HashMap;
use std::path::Path;

/// Included files within included files, at most.
const DEEPEST: usize = 8;
/// Included files, at most: decks that include each other twice would never end.
const MOST_FILES: usize = 1000;
/// Names of ignored keywords that are kept, and those that a note gives.
const MOST_IGNORED: usize = 50;
const MOST_NAMED: usize = 6;
/// Numbers of an element that fit in one line of most programs.
const LONGEST: usize = 11;
/// Keywords that make, move or rename nodes and elements.
const REFUSED: [&str; 10] = [
    "SYSTEM",
    "NGEN",
    "NFILL",
    "NCOPY",
    "NMAP",
    "ELGEN",
    "ELCOPY",
    "SUBSTRUCTURE PATH",
    "IMPORT",
    "PARAMETER",
];
/// Keywords that are passed over without counting them.
const SILENT: [&str; 3] = ["HEADING", "PREPRINT", "END"];

/// The block to which the data lines belong.
#[derive(Default)]
enum Block {
    /// A block that is not read.
    #[default]
    None,
    Nodes {
        set: Option<usize>,
    },
    Elements {
        kind: ElementKind,
        name: String,
        set: Option<usize>,
        pending: Vec<u64>,
    },
    /// Springs and masses: only their numbers are kept, for sets that name them.
    NoCells {
        set: Option<usize>,
        continued: bool,
    },
    Set {
        of_nodes: bool,
        set: usize,
        generate: bool,
        /// The instance that its entries belong to, if it is not the one being read.
        instance: Option<usize>,
    },
    Surface {
        surface: usize,
    },
    /// The position of an instance.
    Instance {
        part: usize,
        motion: Motion,
    },
    /// Elements of a type that is not read: counted for the message.
    Refused {
        name: String,
        count: usize,
        spot: Spot,
    },
}

/// A deck while it is read.
#[derive(Default)]
pub(super) struct Deck {
    collector: Collector,
    sets: Sets,
    block: Block,
    parts: Vec<Part>,
    /// The index in `parts`, by the name in upper case.
    part_index: HashMap<String, usize>,
    /// The frame of the lines being read.
    frame: Frame,
    /// The frames of the instances that have ended.
    frames: Vec<Frame>,
    frame_index: HashMap<String, usize>,
    /// True while lines of a part are read for an instance.
    in_part: bool,
    /// True if there are nodes or elements outside parts and assembly.
    numbers_outside: bool,
    /// Names of ignored keywords and how often they appeared.
    ignored: Vec<(String, usize)>,
    bytes: usize,
    /// Bytes of the parts that instances repeat.
    repeated: usize,
}

impl Deck {
    pub(super) fn new(name: &str) -> Self {
        Self { collector: Collector::new(name), ..Self::default() }
    }

    /// Reads one file; those it includes are read in place.
    pub(super) fn read(
        &mut self,
        bytes: &[u8],
        path: &Path,
        depth: usize,
        include: Includes<'_>,
    ) -> Result<(), MeshFileError> {
        let file = u16::try_from(self.collector.files.len() - 1).unwrap_or(u16::MAX);
        if self.in_part {
            self.spend_repeated(bytes.len(), Spot { file, line: 0 })?;
        } else {
            self.bytes += bytes.len();
        }
        let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
        self.lines(bytes, Spot { file, line: 1 }, path, depth, include)
    }

    /// Reads lines of a file.
    ///
    /// * `first`: the place of the first.
    fn lines(
        &mut self,
        bytes: &[u8],
        first: Spot,
        path: &Path,
        depth: usize,
        include: Includes<'_>,
    ) -> Result<(), MeshFileError> {
        let mut lines = bytes.split(|b| *b == b'\n').zip(first.line..).peekable();
        while let Some((line, number)) = lines.next() {
            let spot = Spot { line: number, ..first };
            let line = line.trim_ascii();
            match line {
                [] | [b'*', b'*', ..] | [b'>', b'*', b'*', ..] => {}
                [b'*', rest @ ..] => {
                    let mut text = String::from_utf8_lossy(rest).into_owned();
                    // A comma at the end of a line whose data follow is a slip, not a continuation.
                    let letter = |l: &[u8]| l.trim_ascii_start().first().is_some_and(u8::is_ascii_alphabetic);
                    while text.trim_end().ends_with(',') {
                        let Some((more, _)) = lines.next_if(|(l, _)| letter(l)) else { break };
                        text += &String::from_utf8_lossy(more);
                    }
                    let keyword = Keyword::parse(&text);
                    if keyword.name == "INCLUDE" {
                        self.include(&keyword, path, depth, spot, include)?;
                        continue;
                    }
                    // The position of an instance is known now.
                    if let Block::Instance { part, motion } = self.block {
                        self.block = Block::None;
                        self.repeat(part, motion, depth, include)?;
                    }
                    self.end_block()?;
                    if keyword.name == "PART" {
                        self.keep_part(&keyword, &mut lines, path, spot)?;
                    } else {
                        self.block = self.begin(&keyword, spot)?;
                    }
                }
                data => self.data(data, spot)?,
            }
        }
        Ok(())
    }

    fn include(
        &mut self,
        keyword: &Keyword,
        from: &Path,
        depth: usize,
        spot: Spot,
        include: Includes<'_>,
    ) -> Result<(), MeshFileError> {
        let Some(file) = keyword.value("INPUT") else {
            return Err(self.syntax(spot, "*INCLUDE names no file").expected("*INCLUDE, INPUT=file"));
        };
        if depth >= DEEPEST || self.collector.files.len() > MOST_FILES {
            let found =
                format!("*INCLUDE of \"{file}\": the files include each other too deeply or too often");
            return Err(self.syntax(spot, found).expected(format!(
                "at most {DEEPEST} files within each other and {MOST_FILES} altogether, and no file within itself"
            )));
        }
        let (path, bytes) = include(from, file).map_err(|why| {
            let found = format!("the included file \"{file}\" cannot be read: {}", why.found);
            let mut error = self.syntax(spot, found);
            error.fault = MeshFault::Unreadable;
            error.help(why.fix.unwrap_or("names are relative to the file that includes"))
        })?;
        self.collector.files.push(path.to_string_lossy().into_owned());
        self.read(&bytes, &path, depth + 1, include)
    }

    fn syntax(&self, spot: Spot, found: impl Into<String>) -> MeshFileError {
        let mut error = self.collector.fault(spot, found);
        error.fault = MeshFault::Syntax;
        error
    }

    /// Begins the block of a keyword.
    fn begin(&mut self, keyword: &Keyword, spot: Spot) -> Result<Block, MeshFileError> {
        let name = keyword.name.as_str();
        match name {
            "NODE" | "ELEMENT" if keyword.has("INPUT") => {
                let found = format!("*{name} takes its data from another file");
                Err(self.syntax(spot, found).expected("the data lines below it, or *INCLUDE"))
            }
            "NODE" => self.begin_nodes(keyword, spot),
            "ELEMENT" => self.begin_elements(keyword, spot),
            "NSET" | "ELSET" => {
                let Some(set) = keyword.value(name) else {
                    return Err(self
                        .syntax(spot, format!("*{name} has no name"))
                        .expected(format!("*{name}, {name}=name")));
                };
                let of_nodes = name == "NSET";
                let instance = keyword.value("INSTANCE");
                let instance = instance.map(|instance| self.instance(instance, spot)).transpose()?;
                let set = self.set_name(set, spot)?;
                let set = self.sets.registry(of_nodes).define(&set);
                Ok(Block::Set { of_nodes, set, generate: keyword.has("GENERATE"), instance })
            }
            "SURFACE" => {
                let Some(surface) = keyword.value("NAME") else {
                    return Err(self.syntax(spot, "*SURFACE has no name").expected("*SURFACE, NAME=name"));
                };
                let of_nodes = match keyword.value("TYPE").map(upper).as_deref() {
                    None | Some("ELEMENT") => false,
                    Some("NODE") => true,
                    Some(other) => {
                        let found = format!("*SURFACE has the type {other}");
                        return Err(self.syntax(spot, found).expected("ELEMENT or NODE"));
                    }
                };
                let surface = self.set_name(surface, spot)?;
                Ok(Block::Surface { surface: self.sets.define_surface(&surface, of_nodes) })
            }
            "ASSEMBLY" => self.begin_assembly(spot),
            "END ASSEMBLY" if self.frame.instance.is_some() => Err(self.no_end(spot)),
            "INSTANCE" => self.begin_instance(keyword, spot),
            "END INSTANCE" => self.end_instance(spot),
            _ if REFUSED.contains(&name) => Err(self.refusal(name, spot)),
            _ if SILENT.iter().any(|word| name.split(' ').next() == Some(word)) => Ok(Block::None),
            _ => {
                self.ignore(name);
                Ok(Block::None)
            }
        }
    }

    /// Counts a keyword that does not describe the mesh.
    fn ignore(&mut self, name: &str) {
        let known = self.ignored.iter().position(|(ignored, _)| ignored == name);
        match known {
            Some(place) => self.ignored[place].1 += 1,
            // The rest is counted with the last of them.
            None if self.ignored.len() < MOST_IGNORED => self.ignored.push((name.to_owned(), 1)),
            None => self.ignored[MOST_IGNORED - 1].1 += 1,
        }
    }

    fn refusal(&self, name: &str, spot: Spot) -> MeshFileError {
        let mut error = self.syntax(spot, format!("*{name} is not read"));
        error.fault = MeshFault::Format;
        error.expected("nodes and elements written out one by one")
    }

    fn begin_nodes(&mut self, keyword: &Keyword, spot: Spot) -> Result<Block, MeshFileError> {
        if keyword.value("SYSTEM").is_some_and(|s| !s.eq_ignore_ascii_case("R")) {
            let found = "*NODE has a SYSTEM other than the rectangular one";
            return Err(self.syntax(spot, found).expected("Cartesian coordinates"));
        }
        let set = keyword.value("NSET").map(|set| self.set_name(set, spot)).transpose()?;
        let set = set.map(|set| self.sets.nodes.define(&set));
        Ok(Block::Nodes { set })
    }

    fn begin_elements(&mut self, keyword: &Keyword, spot: Spot) -> Result<Block, MeshFileError> {
        let Some(name) = keyword.value("TYPE").map(upper) else {
            return Err(self
                .syntax(spot, "*ELEMENT has no TYPE")
                .expected("*ELEMENT, TYPE=CPS3 or the like"));
        };
        let set = keyword.value("ELSET").map(|set| self.set_name(set, spot)).transpose()?;
        let mut define = || set.as_deref().map(|set| self.sets.elements.define(set));
        if data::is_no_cell(&name) {
            let set = define();
            self.ignore(&format!("ELEMENT, TYPE={name}"));
            return Ok(Block::NoCells { set, continued: false });
        }
        match data::kind(&name) {
            Some(kind) => {
                let set = define();
                Ok(Block::Elements { kind, name, set, pending: Vec::new() })
            }
            None => Ok(Block::Refused { name, count: 0, spot }),
        }
    }

    /// Checks that a block is complete.
    fn end_block(&mut self) -> Result<(), MeshFileError> {
        match std::mem::take(&mut self.block) {
            Block::Refused { name, count, spot } => {
                let mut error = self.syntax(spot, format!("{} of type {name}", counted(count, "element")));
                error.fault = MeshFault::Format;
                let error = error.expected(
                    "plane elements (CPS3, CPE4, CPS6, CPE8 and the like), volumes (C3D4, C3D6, C3D8, C3D10, C3D15, C3D20 and the like) or \
                     line elements",
                );
                Err(error.help(data::advice(&name)))
            }
            Block::Elements { pending, name, .. } if !pending.is_empty() => {
                let found = format!(
                    "the data of element {} ({name}) ended after {} numbers",
                    pending[0],
                    pending.len()
                );
                Err(self.syntax(Spot::default(), found).expected("all its nodes"))
            }
            _ => Ok(()),
        }
    }

    /// Takes a data line of *ELEMENT, whose data may continue in the next one.
    fn element(&mut self, row: &DataLine<'_>, spot: Spot) -> Result<(), MeshFileError> {
        let Block::Elements { kind, name, set, pending } = &mut self.block else { return Ok(()) };
        let needed = kind.nodes() + 1;
        let more = row.numbers(pending);
        let (kind, set, len) = (*kind, *set, pending.len());
        let mut numbers = if len >= needed { std::mem::take(pending) } else { Vec::new() };
        let shell = data::is_shell(name);
        let name = if len == needed { String::new() } else { name.clone() };
        more.map_err(|fault| fault.at(self.syntax(spot, "")))?;
        // Not all programs write the comma at the end of a line that is not the last one of an element.
        let continues = row.continues() || needed > LONGEST;
        if len > needed || (len < needed && !continues) {
            let found = format!("an element of type {name} has {} nodes", len.saturating_sub(1));
            return Err(self.syntax(spot, found).expected(format!("{}", needed - 1)));
        }
        for number in &mut numbers {
            *number = self.numbered(*number, spot)?;
        }
        if let Some((&number, nodes)) = numbers.split_first() {
            // The ends of a quadratic line are its first and its last node.
            let ends_first = |n: &[u64]| [n[0], n[2], n[1]];
            let reordered = if kind == ElementKind::Edge3 { ends_first(nodes).to_vec() } else { Vec::new() };
            let nodes = if reordered.is_empty() { nodes } else { &reordered };
            self.collector.element(number, kind, nodes, 0, spot);
            if shell {
                self.sets.shells.push(number);
            }
            // All elements of an instance are a set of its name.
            if let (Some(instance), None) = (&self.frame.instance, self.frame.whole) {
                self.frame.whole = Some(self.sets.elements.define(instance));
            }
            for set in [set, self.frame.whole].into_iter().flatten() {
                self.sets.elements.add_number(set, number, spot);
            }
        }
        Ok(())
    }

    /// Returns the number in the deck of a node or an element.
    fn numbered(&mut self, number: u64, spot: Spot) -> Result<u64, MeshFileError> {
        self.numbers_outside |= !self.frame.in_assembly;
        self.frame.number(number).map_err(|fault| fault.at(self.syntax(spot, "")))
    }

    /// Hands a data line to its block.
    fn data(&mut self, line: &[u8], spot: Spot) -> Result<(), MeshFileError> {
        let row = DataLine::new(line);
        match &mut self.block {
            Block::None => Ok(()),
            Block::Refused { count, .. } => {
                *count += 1;
                Ok(())
            }
            Block::Nodes { set } => {
                let set = *set;
                let (number, point) = row.node().map_err(|fault| fault.at(self.syntax(spot, "")))?;
                let number = self.numbered(number, spot)?;
                self.collector.node(number, self.frame.point(point), spot)?;
                if let Some(set) = set {
                    self.sets.nodes.add_number(set, number, spot);
                }
                Ok(())
            }
            Block::Elements { .. } => self.element(&row, spot),
            Block::NoCells { set, continued } => {
                let (set, first) = (*set, !*continued);
                *continued = row.continues();
                if first {
                    let number = row.number().map_err(|fault| fault.at(self.syntax(spot, "")))?;
                    let number = self.numbered(number, spot)?;
                    self.sets.no_cells.push(number);
                    if let Some(set) = set {
                        self.sets.elements.add_number(set, number, spot);
                    }
                }
                Ok(())
            }
            Block::Set { of_nodes, set, generate, instance } => {
                let (of_nodes, set, generate, instance) = (*of_nodes, *set, *generate, *instance);
                let frame = instance.map_or(&self.frame, |instance| &self.frames[instance]);
                let entries = set_entries(&row, generate)
                    .and_then(|all| all.into_iter().map(|entry| self.entry(frame, entry)).collect())
                    .map_err(|fault| fault.at(self.syntax(spot, "")))?;
                self.sets.registry(of_nodes).add(set, entries, spot);
                Ok(())
            }
            Block::Surface { surface } => {
                let surface = *surface;
                let of_nodes = self.sets.surfaces[surface].of_nodes;
                let entry = surface_entry(&row, of_nodes)
                    .and_then(|(target, face)| Ok((self.target(target)?, face)))
                    .map_err(|fault| fault.at(self.syntax(spot, "")))?;
                Surface::add(&mut self.sets.surfaces[surface], entry, spot);
                Ok(())
            }
            Block::Instance { motion, .. } => {
                let added = motion.add(&row);
                added.map_err(|fault| fault.at(self.syntax(spot, "")))
            }
        }
    }

    /// Puts everything together.
    pub(super) fn finish(mut self) -> Result<MeshFile, MeshFileError> {
        self.end_block()?;
        if self.frame.instance.is_some() {
            return Err(self.no_end(self.frame.began));
        }
        if self.collector.element_count() == 0 {
            let error = self.syntax(Spot::default(), "the deck has no elements");
            let of_parts = "*INSTANCE of its parts in *ASSEMBLY, and *NODE and *ELEMENT in them";
            let alone = "*NODE and *ELEMENT with their data lines";
            return Err(error.expected(if self.parts.is_empty() { alone } else { of_parts }));
        }
        let files = self.collector.files.clone();
        let mut mesh = self.collector.finish("Abaqus input deck".to_owned())?.mesh;
        self.sets.apply(&mut mesh, &files, self.bytes.saturating_add(self.repeated))?;
        let unused: Vec<&str> =
            self.parts.iter().filter(|part| !part.used).map(|part| part.name.as_str()).collect();
        if !unused.is_empty() {
            let named = unused.iter().take(MOST_NAMED).copied().collect::<Vec<_>>().join(", ");
            let dots = if unused.len() > MOST_NAMED { ", …" } else { "" };
            mesh.push_note(format!("{} without an instance: {named}{dots}", counted(unused.len(), "part")));
        }
        let total: usize = self.ignored.iter().map(|(_, count)| count).sum();
        if total > 0 {
            let names: Vec<&str> =
                self.ignored.iter().take(MOST_NAMED).map(|(name, _)| name.as_str()).collect();
            let dots = if self.ignored.len() > names.len() { ", …" } else { "" };
            mesh.push_note(format!(
                "{} that do not describe the mesh were ignored: {}{dots}",
                counted(total, "keyword"),
                names.join(", ")
            ));
        }
        Ok(mesh)
    }
}
