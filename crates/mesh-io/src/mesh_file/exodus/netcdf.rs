//! The classic netCDF file: dimensions, variables and their values, all big-endian.
//!
//! The format is that of Unidata's "NetCDF Classic Format Specification": a header with all names and places, and then the values. In CDF-2
//! places have 64 bits, in CDF-5 counts too. Variables along the dimension without a length (time) are listed, but have no values here.

use crate::mesh_file::{MeshFault, MeshFileError, MeshPlace};
use std::cell::Cell;
use std::collections::HashMap;

/// Tags of the lists of a header.
const DIMENSIONS: u32 = 10;
const VARIABLES: u32 = 11;
const ATTRIBUTES: u32 = 12;

/// The types of values: number in the file, bytes of one.
const CHAR: u32 = 2;
const SIZES: [(u32, u64); 11] =
    [(1, 1), (CHAR, 1), (3, 2), (4, 4), (5, 4), (6, 8), (7, 1), (8, 2), (9, 4), (10, 8), (11, 8)];

/// The dimensions and variables of a file.
pub(super) struct NetCdf<'a> {
    file: &'a str,
    bytes: &'a [u8],
    /// 1, 2 or 5.
    pub(super) version: u8,
    /// Names and lengths; the length 0 is that of time.
    dimensions: Vec<(&'a [u8], u64)>,
    variables: Vec<Variable<'a>>,
    index: HashMap<&'a [u8], usize>,
    /// Bytes that may still be read: no more than the file has, though variables may overlap in a damaged one.
    left: Cell<usize>,
}

/// A variable as the header has it.
pub(super) struct Variable<'a> {
    name: &'a [u8],
    /// Length of each dimension.
    pub(super) lengths: Vec<u64>,
    /// The text of the attribute `elem_type`.
    pub(super) element_type: &'a [u8],
    kind: u32,
    begin: u64,
}

impl<'a> NetCdf<'a> {
    /// Reads the header.
    ///
    /// * `file`: what messages call it.
    pub(super) fn parse(bytes: &'a [u8], file: &'a str) -> Result<Self, MeshFileError> {
        let version = bytes.get(3).copied().unwrap_or_default();
        let mut header = Header { file, bytes, at: 4, wide: version == 5 };
        if !matches!(version, 1 | 2 | 5) {
            let error =
                header.fault(MeshFault::Format, format!("this is version {version} of classic netCDF"));
            return Err(error.expected("1, 2 or 5").help("convert it: nccopy -k classic FILE new.e"));
        }
        // The number of time steps.
        header.count()?;
        let mut dimensions = Vec::new();
        for _ in 0..header.list(DIMENSIONS)? {
            dimensions.push((header.name()?, header.count()?));
        }
        header.attributes()?;
        let mut variables: Vec<Variable<'a>> = Vec::new();
        for _ in 0..header.list(VARIABLES)? {
            let name = header.name()?;
            let mut lengths = Vec::new();
            for _ in 0..header.count()? {
                let number = header.count()?;
                let dimension = usize::try_from(number).ok().and_then(|k| dimensions.get(k));
                let Some((_, length)) = dimension else {
                    let found = format!("a variable has the dimension {number}");
                    return Err(header
                        .fault(MeshFault::Syntax, found)
                        .expected(format!("below {}", dimensions.len())));
                };
                lengths.push(*length);
            }
            let element_type = header.attributes()?;
            let kind = header.word()?;
            // Its size, which follows from type and dimensions.
            header.count()?;
            let begin = if version == 1 { u64::from(header.word()?) } else { header.long()? };
            variables.push(Variable { name, lengths, element_type, kind, begin });
        }
        let index = variables.iter().enumerate().map(|(k, variable)| (variable.name, k)).collect();
        Ok(Self { file, bytes, version, dimensions, variables, index, left: Cell::new(bytes.len()) })
    }

    /// Returns the length of a dimension.
    pub(super) fn length(&self, name: &str) -> Option<u64> {
        self.dimensions.iter().find(|(known, _)| *known == name.as_bytes()).map(|(_, length)| *length)
    }

    /// Finds a variable.
    pub(super) fn variable(&self, name: &str) -> Option<&Variable<'a>> {
        self.index.get(name.as_bytes()).map(|k| &self.variables[*k])
    }

    /// Makes an error about the file as a whole.
    pub(super) fn fault(&self, fault: MeshFault, found: impl Into<String>) -> MeshFileError {
        MeshFileError::new(fault, self.file, MeshPlace::File, found)
    }

    /// Makes an error at the values of a variable.
    pub(super) fn fault_in(&self, variable: &Variable<'_>, found: impl Into<String>) -> MeshFileError {
        MeshFileError::new(MeshFault::Syntax, self.file, MeshPlace::Byte(variable.begin), found)
    }

    /// Takes the bytes of all values of a variable, if the file has them.
    fn values(&self, variable: &Variable<'_>) -> Result<(&'a [u8], usize), MeshFileError> {
        let name = String::from_utf8_lossy(variable.name);
        let Some((_, size)) = SIZES.iter().find(|(kind, _)| *kind == variable.kind) else {
            let found = format!("the variable {name} has the type {}", variable.kind);
            return Err(self.fault_in(variable, found).expected("1 to 11"));
        };
        let bytes = variable.lengths.iter().try_fold(*size, |bytes, length| bytes.checked_mul(*length));
        let end = bytes.and_then(|bytes| variable.begin.checked_add(bytes));
        let place = usize::try_from(variable.begin).ok().zip(end.and_then(|end| usize::try_from(end).ok()));
        match place.and_then(|(begin, end)| self.bytes.get(begin..end)) {
            Some(values) => match self.left.get().checked_sub(values.len()) {
                Some(left) => {
                    self.left.set(left);
                    Ok((values, *size as usize))
                }
                None => {
                    Err(self.fault_in(variable, "the variables have more values than the file has bytes"))
                }
            },
            None => {
                let found =
                    format!("the file ends before the values of {name}: it has {} bytes", self.bytes.len());
                let error = self.fault_in(variable, found);
                Err(error.expected("a complete file; it may have been cut while it was copied"))
            }
        }
    }

    /// Reads whole numbers.
    pub(super) fn integers(&self, variable: &Variable<'_>) -> Result<Vec<i64>, MeshFileError> {
        let (values, size) = self.values(variable)?;
        let signed = match variable.kind {
            1 | 3 | 4 | 10 => true,
            7 | 8 | 9 | 11 => false,
            _ => return Err(self.wrong_type(variable, "whole numbers")),
        };
        let read = |bytes: &[u8]| {
            let fill = if signed && bytes[0] >= 0x80 { u64::MAX } else { 0 };
            bytes.iter().fold(fill, |value, byte| value << 8 | u64::from(*byte)) as i64
        };
        Ok(values.chunks_exact(size).map(read).collect())
    }

    /// Reads numbers of nodes, elements or sides, from 1.
    pub(super) fn numbers(&self, variable: &Variable<'_>) -> Result<Vec<u64>, MeshFileError> {
        let natural = |number: i64| {
            u64::try_from(number).ok().filter(|number| *number > 0).ok_or_else(|| {
                let name = String::from_utf8_lossy(variable.name);
                self.fault_in(variable, format!("{name} holds {number}")).expected("numbers from 1")
            })
        };
        self.integers(variable)?.into_iter().map(natural).collect()
    }

    /// Reads real numbers.
    pub(super) fn reals(&self, variable: &Variable<'_>) -> Result<Vec<f64>, MeshFileError> {
        let (values, size) = self.values(variable)?;
        let single = |bytes: &[u8; 4]| f64::from(f32::from_be_bytes(*bytes));
        match (variable.kind, size) {
            (5, _) => Ok(values.as_chunks::<4>().0.iter().map(single).collect()),
            (6, _) => Ok(values.as_chunks::<8>().0.iter().map(|bytes| f64::from_be_bytes(*bytes)).collect()),
            _ => Err(self.wrong_type(variable, "real numbers")),
        }
    }

    /// Reads texts, one for each row of the last dimension, without what follows a zero byte.
    pub(super) fn texts(&self, variable: &Variable<'_>) -> Result<Vec<String>, MeshFileError> {
        let (values, _) = self.values(variable)?;
        let Some(length) = variable.lengths.last().filter(|_| variable.kind == CHAR) else {
            return Err(self.wrong_type(variable, "texts"));
        };
        // The values are in the file, and so is their length.
        let rows = values.chunks_exact(usize::try_from(*length).unwrap_or(usize::MAX).max(1));
        let text = |row: &[u8]| String::from_utf8_lossy(until_zero(row)).trim().to_owned();
        Ok(rows.map(text).collect())
    }

    fn wrong_type(&self, variable: &Variable<'_>, expected: &str) -> MeshFileError {
        let name = String::from_utf8_lossy(variable.name);
        self.fault_in(variable, format!("the variable {name} has the type {}", variable.kind))
            .expected(expected)
    }
}

/// Returns the bytes before the first zero byte.
pub(super) fn until_zero(text: &[u8]) -> &[u8] {
    text.split(|byte| *byte == 0).next().unwrap_or_default()
}

/// A cursor over the header.
struct Header<'a> {
    file: &'a str,
    bytes: &'a [u8],
    at: usize,
    /// True if counts have 64 bits.
    wide: bool,
}

impl<'a> Header<'a> {
    fn fault(&self, fault: MeshFault, found: impl Into<String>) -> MeshFileError {
        MeshFileError::new(fault, self.file, MeshPlace::Byte(self.at as u64), found)
    }

    /// Takes bytes; those up to the next multiple of four are skipped.
    fn take(&mut self, count: u64) -> Result<&'a [u8], MeshFileError> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let Some(taken) = usize::try_from(count).ok().and_then(|count| rest.get(..count)) else {
            let error = self.fault(MeshFault::Syntax, "the file ended inside its header");
            return Err(error.expected("a complete file; it may have been cut while it was copied"));
        };
        self.at += taken.len().next_multiple_of(4);
        Ok(taken)
    }

    fn word(&mut self) -> Result<u32, MeshFileError> {
        Ok(self.take(4)?.iter().fold(0, |value, byte| value << 8 | u32::from(*byte)))
    }

    fn long(&mut self) -> Result<u64, MeshFileError> {
        Ok(u64::from(self.word()?) << 32 | u64::from(self.word()?))
    }

    fn count(&mut self) -> Result<u64, MeshFileError> {
        if self.wide { self.long() } else { Ok(u64::from(self.word()?)) }
    }

    fn name(&mut self) -> Result<&'a [u8], MeshFileError> {
        let length = self.count()?;
        self.take(length)
    }

    /// Reads the head of a list: how many items follow. Every item has bytes, so a count that is too large ends with the file.
    fn list(&mut self, expected: u32) -> Result<u64, MeshFileError> {
        let tag = self.word()?;
        let count = self.count()?;
        if tag == expected || (tag == 0 && count == 0) {
            return Ok(count);
        }
        let error = self.fault(MeshFault::Syntax, format!("a list of the header has the mark {tag}"));
        Err(error.expected(format!("{expected}, or 0 for an empty list")))
    }

    /// Skips attributes; returns the text of `elem_type`.
    fn attributes(&mut self) -> Result<&'a [u8], MeshFileError> {
        let mut element_type: &[u8] = &[];
        for _ in 0..self.list(ATTRIBUTES)? {
            let name = self.name()?;
            let kind = self.word()?;
            let count = self.count()?;
            let size = SIZES.iter().find(|(known, _)| *known == kind).map(|(_, size)| *size);
            let Some(bytes) = size.and_then(|size| count.checked_mul(size)) else {
                let error = self
                    .fault(MeshFault::Syntax, format!("{count} values of an attribute have the type {kind}"));
                return Err(error.expected("the types 1 to 11"));
            };
            let values = self.take(bytes)?;
            if name == b"elem_type" && kind == CHAR {
                element_type = values;
            }
        }
        Ok(element_type)
    }
}
