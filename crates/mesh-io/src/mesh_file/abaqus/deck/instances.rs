//! Parts and their instances, as Abaqus/CAE writes them.
//!
//! The lines of a part are kept, and read once for each of its instances. Numbers of the first instance remain; those of the others
//! follow with a round offset. Names of sets and surfaces of a part get the name of the instance before them, `plate-1.top`.

use super::super::data::{self, Row};
use super::super::keyword::{Keyword, upper};
use super::super::sets::{Entry, Target};
use super::{Block, Deck};
use crate::mesh_file::{Includes, MeshFileError, Spot};
use crate::words::did_you_mean;
use fem_core::geometry::Vector;
use std::path::{Path, PathBuf};

/// Bytes of parts that instances may repeat: a few lines could ask for any number of copies.
const MOST_REPEATED: usize = 1 << 30;

/// The lines of a part.
pub(super) struct Part {
    pub(super) name: String,
    pub(super) text: Vec<u8>,
    /// The file they are in, and the place of the first.
    pub(super) path: PathBuf,
    pub(super) first: Spot,
    pub(super) used: bool,
}

/// How an instance moves its part: a translation, and a rotation about an axis along z after it.
#[derive(Clone, Copy, Default)]
pub(super) struct Motion {
    shift: [f64; 3],
    turn: Option<Turn>,
}

#[derive(Clone, Copy)]
struct Turn {
    centre: Vector,
    cosine_sine: [f64; 2],
}

impl Motion {
    /// Takes a data line of an instance: the first is a translation, the second a rotation.
    pub(super) fn add(&mut self, row: &Row<'_>, line: usize) -> Result<(), data::Fault> {
        let mut values = Vec::new();
        for field in row.fields() {
            let value = if field.is_empty() { Some(0.0) } else { data::real(field) };
            let Some(value) = value.filter(|x| x.is_finite()) else {
                let found = format!("found {} in the position of an instance", data::shown(field));
                return Err(data::Fault::new(found, "a finite number"));
            };
            values.push(value);
        }
        let fault = |expected| data::Fault::new("the position of an instance".to_owned(), expected);
        match (line, &values[..]) {
            (0, [x, y]) => self.shift = [*x, *y, 0.0],
            (0, [x, y, z]) => self.shift = [*x, *y, *z],
            (1, [ax, ay, az, bx, by, bz, angle]) => {
                if ax != bx || ay != by || az == bz {
                    return Err(fault("a rotation about an axis along z: the mesh is plane"));
                }
                let (sine, cosine) = if bz > az { *angle } else { -angle }.to_radians().sin_cos();
                self.turn = Some(Turn { centre: Vector::new(*ax, *ay), cosine_sine: [cosine, sine] });
            }
            _ => {
                return Err(fault(
                    "x, y, z of the translation, then two points of the axis and the angle in degrees",
                ));
            }
        }
        Ok(())
    }

    fn applied(&self, point: [f64; 3]) -> [f64; 3] {
        let moved: [f64; 3] = std::array::from_fn(|k| point[k] + self.shift[k]);
        let Some(Turn { centre, cosine_sine: [c, s] }) = self.turn else { return moved };
        let [x, y] = (Vector::new(moved[0], moved[1]) - centre).into();
        [centre[0] + c * x - s * y, centre[1] + s * x + c * y, moved[2]]
    }
}

/// Where numbers, names and points of the lines that are read belong.
#[derive(Clone, Default)]
pub(super) struct Frame {
    /// The name of the instance; `None` in the assembly, and in a deck without parts.
    pub(super) instance: Option<String>,
    pub(super) motion: Motion,
    /// What is added to all numbers.
    pub(super) offset: u64,
}

impl Frame {
    /// Says whether it is that of an instance.
    pub(super) fn is(&self, instance: &str) -> bool {
        self.instance.as_ref().is_some_and(|name| upper(name) == upper(instance))
    }

    /// Returns the number in the deck. Numbers too large for that collide, which is found later.
    pub(super) fn number(&self, number: u64) -> u64 {
        number.saturating_add(self.offset)
    }

    /// Returns the name in the deck.
    pub(super) fn name(&self, name: &str) -> String {
        self.instance.as_ref().map_or_else(|| name.to_owned(), |instance| format!("{instance}.{name}"))
    }

    pub(super) fn point(&self, point: [f64; 3]) -> [f64; 3] {
        self.motion.applied(point)
    }

    pub(super) fn entry(&self, entry: Entry) -> Entry {
        match entry {
            Entry::Range { from, to, step } => {
                Entry::Range { from: self.number(from), to: self.number(to), step }
            }
            Entry::Name(name) => Entry::Name(self.name(&name)),
        }
    }

    pub(super) fn target(&self, target: Target) -> Target {
        match target {
            Target::Number(number) => Target::Number(self.number(number)),
            Target::Name(name) => Target::Name(self.name(&name)),
        }
    }
}

/// Says whether the text behind a star is a keyword without parameters.
fn is_keyword(text: &[u8], name: &str) -> bool {
    upper(&String::from_utf8_lossy(text)) == name
}

impl Deck {
    /// Keeps the lines of a part for its instances.
    pub(super) fn keep_part<'a>(
        &mut self,
        keyword: &Keyword,
        lines: &mut impl Iterator<Item = (&'a [u8], u32)>,
        path: &Path,
        spot: Spot,
    ) -> Result<(), MeshFileError> {
        let Some(name) = keyword.value("NAME") else {
            return Err(self.syntax(spot, "*PART has no name").expected("*PART, NAME=name"));
        };
        if self.outside.is_some() {
            return Err(self.syntax(spot, "*PART within an instance").expected("parts before the assembly"));
        }
        let mut text = Vec::new();
        let mut first = None;
        for (line, number) in lines {
            let first = *first.get_or_insert(number);
            if line.trim_ascii().strip_prefix(b"*").is_some_and(|rest| is_keyword(rest, "END PART")) {
                let first = Spot { line: first, ..spot };
                let part = Part { name: name.to_owned(), text, path: path.to_owned(), first, used: false };
                self.parts.push(part);
                return Ok(());
            }
            text.extend_from_slice(line);
            text.push(b'\n');
        }
        Err(self.syntax(spot, format!("part \"{name}\" has no end")).expected("*END PART"))
    }

    pub(super) fn begin_instance(&mut self, keyword: &Keyword, spot: Spot) -> Result<Block, MeshFileError> {
        let (Some(name), Some(part)) = (keyword.value("NAME"), keyword.value("PART")) else {
            let error = self.syntax(spot, "*INSTANCE without its name or its part");
            return Err(error.expected("*INSTANCE, NAME=name, PART=part of this deck"));
        };
        if self.outside.is_some() || self.frames.iter().any(|frame| frame.is(name)) {
            let found = format!("instance \"{name}\" begins within another one, or a second time");
            return Err(self.syntax(spot, found).expected("*END INSTANCE before it, and every name once"));
        }
        let Some(known) = self.parts.iter().position(|known| upper(&known.name) == upper(part)) else {
            let error = self.syntax(spot, format!("there is no part \"{part}\""));
            let error = error.expected("a part that the deck has before its assembly");
            let names = self.parts.iter().map(|part| part.name.as_str());
            return Err(match did_you_mean(part, names, '"') {
                Some(help) => error.help(help),
                None => error,
            });
        };
        let frame = Frame { instance: Some(name.to_owned()), offset: self.next_offset(), ..Frame::default() };
        self.outside = Some(std::mem::replace(&mut self.frame, frame));
        Ok(Block::Instance { part: known, motion: Motion::default(), lines: 0 })
    }

    /// Reads the lines of a part for the instance that has begun.
    pub(super) fn repeat(
        &mut self,
        part: usize,
        motion: Motion,
        depth: usize,
        include: Includes<'_>,
    ) -> Result<(), MeshFileError> {
        self.frame.motion = motion;
        let known = &mut self.parts[part];
        known.used = true;
        let (text, path, first) = (std::mem::take(&mut known.text), known.path.clone(), known.first);
        self.repeated = self.repeated.saturating_add(text.len());
        if self.repeated > MOST_REPEATED.max(self.bytes) {
            let name = &self.parts[part].name;
            let error = self.syntax(first, format!("the instances repeat part \"{name}\" too often"));
            return Err(
                error.expected(format!("at most {MOST_REPEATED} bytes of parts with all repetitions"))
            );
        }
        self.lines(&text, first, &path, depth, include)?;
        self.end_block()?;
        self.parts[part].text = text;
        Ok(())
    }

    /// Finds an instance that has ended.
    pub(super) fn instance(&self, name: &str, spot: Spot) -> Result<&Frame, MeshFileError> {
        self.frames.iter().find(|frame| frame.is(name)).ok_or_else(|| {
            let names = self.frames.iter().filter_map(|frame| frame.instance.as_deref());
            let error = self.syntax(spot, format!("there is no instance \"{name}\""));
            let error = error.expected("an instance that the assembly has before it");
            match did_you_mean(name, names, '"') {
                Some(help) => error.help(help),
                None => error,
            }
        })
    }

    /// Nodes of the assembly itself, such as reference points, have numbers of their own.
    pub(super) fn number_assembly(&mut self) {
        if self.in_assembly && self.outside.is_none() && self.frame.offset == 0 {
            self.frame.offset = self.next_offset();
        }
    }

    /// Returns the number in the deck of a node or an element that begins here.
    pub(super) fn numbered(&mut self, number: u64) -> u64 {
        let in_deck = self.frame.number(number);
        self.largest = [self.largest[0].max(number), self.largest[1].max(in_deck)];
        in_deck
    }

    /// Returns the offset of the next instance: above all numbers so far, a multiple of a power of ten above those in the parts.
    fn next_offset(&self) -> u64 {
        let [in_part, in_deck] = self.largest;
        if in_deck == 0 {
            return 0;
        }
        let powers = std::iter::successors(Some(10u64), |power| power.checked_mul(10));
        let step = powers.into_iter().find(|power| *power > in_part).unwrap_or(u64::MAX);
        (in_deck / step + 1).saturating_mul(step)
    }
}
