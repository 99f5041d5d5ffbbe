//! Parts and their instances, as Abaqus/CAE writes them.
//!
//! The lines of a part are kept, and read once for each of its instances. Every instance has a space of numbers of its own, and so has the
//! assembly: node 7 of the second instance is 2000000000007 in messages, node 7 of the assembly 1000000000007. Numbers of the first instance
//! remain. Names of sets and surfaces of a part get the name of the instance before them, `plate-1.top`.

use super::super::data::{self, DataLine};
use super::super::keyword::{Keyword, upper};
use super::super::sets::{Entry, Target};
use super::{Block, Deck};
use crate::mesh_file::{Includes, MeshFileError, Spot};
use fem_core::space::{Solid, Space};
use std::path::{Path, PathBuf};

type Vector = <Solid as Space>::Vector;

/// Bytes of parts that instances may repeat: this number, and this multiple of the deck. A few lines could ask for any number of copies.
const MOST_REPEATED: usize = 1 << 26;
const MOST_TIMES: usize = 8;
/// Numbers of an instance are below this.
const SPACE: u64 = 1_000_000_000_000;
/// The space of the assembly. The first instance has space 0 if nothing lies outside the parts; other instances have a space above 1.
const OF_ASSEMBLY: u64 = 1;

/// The lines of a part.
pub(super) struct Part {
    pub(super) name: String,
    text: Vec<u8>,
    /// The file they are in, and the place of the first.
    path: PathBuf,
    first: Spot,
    pub(super) used: bool,
}

/// How an instance moves its part: a translation, and a rotation about an axis after it.
#[derive(Clone, Copy, Default)]
pub(super) struct Motion {
    shift: [f64; 3],
    turn: Option<Turn>,
}

#[derive(Clone, Copy)]
struct Turn {
    centre: Vector,
    /// Of length 1.
    axis: Vector,
    cosine: f64,
    sine: f64,
}

impl Motion {
    /// Takes a data line of an instance: up to three numbers are a translation, more of them a rotation.
    pub(super) fn add(&mut self, row: &DataLine<'_>) -> Result<(), data::Fault> {
        let mut values = Vec::new();
        for field in row.fields() {
            let value = if field.is_empty() { Some(0.0) } else { data::real(field) };
            let Some(value) = value.filter(|x| x.is_finite()) else {
                let found = format!("found {} in the position of an instance", data::shown(field));
                return Err(data::Fault::new(found, "a finite number"));
            };
            values.push(value);
        }
        let get = |k: usize| values.get(k).copied().unwrap_or(0.0);
        match values.len() {
            1..=3 => self.shift = [get(0), get(1), get(2)],
            6 | 7 => self.turn = turn([get(0), get(1), get(2)], [get(3), get(4), get(5)], get(6))?,
            count => {
                let found = format!("the position of an instance has {count} numbers in a line");
                return Err(data::Fault::new(
                    found,
                    "x, y, z; then two points of an axis and an angle in degrees",
                ));
            }
        }
        Ok(())
    }

    fn applied(&self, point: [f64; 3]) -> [f64; 3] {
        let moved = Vector::from(point) + Vector::from(self.shift);
        let Some(Turn { centre, axis, cosine, sine }) = self.turn else { return moved.into() };
        let arm = moved - centre;
        // The part along the axis stays, the rest is turned.
        let along = axis * axis.dot(&arm);
        (centre + along + (arm - along) * cosine + axis.cross(&arm) * sine).into()
    }
}

/// Makes a rotation by an angle in degrees about the axis from `a` to `b`.
fn turn(a: [f64; 3], b: [f64; 3], angle: f64) -> Result<Option<Turn>, data::Fault> {
    if angle == 0.0 {
        return Ok(None);
    }
    let (centre, axis) = (Vector::from(a), Vector::from(b) - Vector::from(a));
    let length = axis.norm();
    if !(length > 0.0 && length.is_finite()) {
        let found = "the axis of an instance's rotation has no direction".to_owned();
        return Err(data::Fault::new(found, "two different points"));
    }
    // Right angles are exact.
    let quarters = angle / 90.0;
    let (sine, cosine) = match (quarters == quarters.round()).then(|| quarters.rem_euclid(4.0)) {
        Some(0.0) => (0.0, 1.0),
        Some(1.0) => (1.0, 0.0),
        Some(2.0) => (0.0, -1.0),
        Some(3.0) => (-1.0, 0.0),
        _ => angle.to_radians().sin_cos(),
    };
    Ok(Some(Turn { centre, axis: axis / length, cosine, sine }))
}

/// The assembly, or the instance, to which the numbers, names and points of the lines that are read belong.
#[derive(Clone, Default)]
pub(super) struct Frame {
    /// The name of the instance; `None` in the assembly, and in a deck without parts.
    pub(super) instance: Option<String>,
    /// The set of all its elements.
    pub(super) whole: Option<usize>,
    /// The place at which the instance began.
    pub(super) began: Spot,
    motion: Motion,
    space: u64,
    /// True for the assembly and the instances in it: their numbers must stay in the space.
    pub(super) in_assembly: bool,
}

impl Frame {
    fn of_assembly() -> Self {
        Self { space: OF_ASSEMBLY, in_assembly: true, ..Self::default() }
    }

    /// Returns the number in the deck.
    pub(super) fn number(&self, number: u64) -> Result<u64, data::Fault> {
        match number {
            number if !self.in_assembly => Ok(number),
            number if number < SPACE => Ok(self.space * SPACE + number),
            number => Err(data::Fault::new(
                format!("found the number {number} in a part or an assembly"),
                "numbers below 1000000000000",
            )),
        }
    }

    /// Returns the name in the deck.
    pub(super) fn name(&self, name: &str) -> String {
        self.instance.as_ref().map_or_else(|| name.to_owned(), |instance| format!("{instance}.{name}"))
    }

    pub(super) fn point(&self, point: [f64; 3]) -> [f64; 3] {
        self.motion.applied(point)
    }
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
        if self.frame.in_assembly {
            return Err(self.syntax(spot, "*PART in an assembly").expected("parts before the assembly"));
        }
        if self.part_index.contains_key(&upper(name)) {
            let error = self.syntax(spot, format!("part \"{name}\" begins a second time"));
            return Err(error.expected("every name of a part once"));
        }
        let mut text = Vec::new();
        let mut first = None;
        for (line, number) in lines {
            let first = *first.get_or_insert(number);
            if let Some(keyword) = line.trim_ascii().strip_prefix(b"*") {
                match Keyword::parse(&String::from_utf8_lossy(keyword)).name.as_str() {
                    "END PART" => {
                        let first = Spot { line: first, ..spot };
                        self.part_index.insert(upper(name), self.parts.len());
                        let part =
                            Part { name: name.to_owned(), text, path: path.to_owned(), first, used: false };
                        self.parts.push(part);
                        return Ok(());
                    }
                    other @ ("PART" | "ASSEMBLY" | "INSTANCE" | "END INSTANCE" | "STEP") => {
                        let spot = Spot { line: number, ..spot };
                        let error = self.syntax(spot, format!("*{other} before the end of part \"{name}\""));
                        return Err(error.expected("*END PART"));
                    }
                    _ => {}
                }
            }
            text.extend_from_slice(line);
            text.push(b'\n');
        }
        Err(self.syntax(spot, format!("part \"{name}\" has no end")).expected("*END PART"))
    }

    pub(super) fn begin_assembly(&mut self, spot: Spot) -> Result<Block, MeshFileError> {
        if self.frame.in_assembly {
            return Err(self.syntax(spot, "*ASSEMBLY in an assembly").expected("one assembly"));
        }
        self.frame = Frame::of_assembly();
        Ok(Block::None)
    }

    pub(super) fn begin_instance(&mut self, keyword: &Keyword, spot: Spot) -> Result<Block, MeshFileError> {
        let (Some(name), Some(part)) = (keyword.value("NAME"), keyword.value("PART")) else {
            let error = self.syntax(spot, "*INSTANCE without its name or its part");
            return Err(error.expected("*INSTANCE, NAME=name, PART=part of this deck"));
        };
        if !self.frame.in_assembly {
            return Err(self.syntax(spot, "*INSTANCE outside an assembly").expected("*ASSEMBLY before it"));
        }
        if self.frame.instance.is_some() {
            return Err(self.no_end(spot));
        }
        if self.frame_index.contains_key(&upper(name)) || self.sets.has(name) {
            let found = format!("instance \"{name}\" has the name of another one or of a set");
            return Err(self.syntax(spot, found).expected("a name of its own"));
        }
        let Some(&known) = self.part_index.get(&upper(part)) else {
            let error = self.syntax(spot, format!("there is no part \"{part}\""));
            let error = error.expected("a part that the deck has before its assembly");
            return Err(error.or_similar(part, self.parts.iter().map(|part| part.name.as_str())));
        };
        let space = match self.frames.len() as u64 {
            0 if !self.numbers_outside => 0,
            earlier => OF_ASSEMBLY + earlier.max(1),
        };
        self.frame = Frame { instance: Some(name.to_owned()), began: spot, space, ..Frame::of_assembly() };
        Ok(Block::Instance { part: known, motion: Motion::default() })
    }

    pub(super) fn end_instance(&mut self, spot: Spot) -> Result<Block, MeshFileError> {
        let Some(name) = self.frame.instance.as_deref().filter(|_| !self.in_part) else {
            let error = self.syntax(spot, "*END INSTANCE without its beginning");
            return Err(error.expected("*INSTANCE before it"));
        };
        self.frame_index.insert(upper(name), self.frames.len());
        self.frames.push(std::mem::replace(&mut self.frame, Frame::of_assembly()));
        Ok(Block::None)
    }

    /// Makes an error of an instance that was not ended before a place.
    pub(super) fn no_end(&self, before: Spot) -> MeshFileError {
        let name = self.frame.instance.as_deref().unwrap_or_default();
        self.syntax(before, format!("instance \"{name}\" has no end")).expected("*END INSTANCE")
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
        self.spend_repeated(text.len(), first)?;
        self.in_part = true;
        self.lines(&text, first, &path, depth, include)?;
        self.end_block()?;
        self.in_part = false;
        self.parts[part].text = text;
        Ok(())
    }

    /// Counts bytes that an instance repeats.
    pub(super) fn spend_repeated(&mut self, bytes: usize, spot: Spot) -> Result<(), MeshFileError> {
        self.repeated = self.repeated.saturating_add(bytes);
        let most = MOST_REPEATED.saturating_add(self.bytes.saturating_mul(MOST_TIMES));
        if self.repeated <= most {
            return Ok(());
        }
        let error = self.syntax(spot, "the instances repeat their parts too often");
        Err(error.expected(format!("at most {most} bytes of parts with all repetitions")))
    }

    /// Finds an instance that has ended.
    pub(super) fn instance(&self, name: &str, spot: Spot) -> Result<usize, MeshFileError> {
        if let Some(found) = self.frame_index.get(&upper(name)) {
            return Ok(*found);
        }
        if self.frame.instance.as_deref().is_some_and(|open| upper(open) == upper(name)) {
            return Err(self.no_end(spot));
        }
        let error = self.syntax(spot, format!("there is no instance \"{name}\""));
        let error = error.expected("an instance that the assembly has before it");
        Err(error.or_similar(name, self.frames.iter().filter_map(|frame| frame.instance.as_deref())))
    }

    /// Returns the name in the deck of a set or a surface that begins here. In an assembly it must not read like the name of an instance.
    pub(super) fn set_name(&self, name: &str, spot: Spot) -> Result<String, MeshFileError> {
        let mut owners = name.match_indices('.').map(|(end, _)| &name[..end]).chain([name]);
        let taken = |name: &str| self.frame_index.contains_key(&upper(name));
        if self.frame.instance.is_none() && owners.any(taken) {
            let error = self.syntax(
                spot,
                format!("the name \"{name}\" of a set is that of an instance or of a set in it"),
            );
            return Err(error.expected("a name of its own"));
        }
        Ok(self.frame.name(name))
    }

    /// Returns an entry of a set in a frame; `instance.number` is a number there.
    pub(super) fn entry(&self, frame: &Frame, entry: Entry) -> Result<Entry, data::Fault> {
        Ok(match entry {
            Entry::Range { from, to, step } => {
                // A range may go beyond what there is, but not into another instance.
                let most = if frame.in_assembly { SPACE - 1 } else { u64::MAX };
                let to = if from == to { to } else { to.min(most).max(from) };
                Entry::Range { from: frame.number(from)?, to: frame.number(to)?, step }
            }
            Entry::Name(name) => match self.number_of(frame, &name) {
                Some(number) => {
                    let number = number?;
                    Entry::Range { from: number, to: number, step: 1 }
                }
                None => Entry::Name(frame.name(&name)),
            },
        })
    }

    /// Returns what a line of a surface refers to.
    pub(super) fn target(&self, target: Target) -> Result<Target, data::Fault> {
        Ok(match target {
            Target::Number(number) => Target::Number(self.frame.number(number)?),
            Target::Name(name) => match self.number_of(&self.frame, &name) {
                Some(number) => Target::Number(number?),
                None => Target::Name(self.frame.name(&name)),
            },
        })
    }

    /// Reads `instance.number` in an assembly.
    fn number_of(&self, frame: &Frame, name: &str) -> Option<Result<u64, data::Fault>> {
        let (instance, number) = name.rsplit_once('.')?;
        let number = data::number(number.as_bytes())?;
        let known = self.frame_index.get(&upper(instance)).filter(|_| frame.instance.is_none())?;
        Some(self.frames[*known].number(number))
    }
}
