//! Unstructured grids of VTK XML: arrays of text, base64 or raw data, also compressed by zlib.

use super::FieldError;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use miniz_oxide::inflate::decompress_to_vec_zlib_with_limit;
use std::collections::HashMap;
use std::str::FromStr;

/// The coordinates of a point in files of VTK.
pub(crate) const VTK_AXES: usize = 3;

/// Makes an error of the file as a whole.
pub(crate) fn fault(reason: impl Into<String>) -> FieldError {
    FieldError::File { reason: reason.into() }
}

/// One array of numbers, not yet decoded.
pub(crate) struct Array {
    pub(crate) name: String,
    /// Such as `Float64`.
    kind: String,
    pub(crate) components: usize,
    source: Source,
}

enum Source {
    Text(String),
    Base64(String),
    Appended(usize),
}

/// A part of the grid.
#[derive(Default)]
pub(crate) struct Piece {
    /// Numbers of points and cells, as the head of the piece has them.
    pub(crate) count: usize,
    pub(crate) cell_count: usize,
    points: Option<Array>,
    /// Arrays at points.
    pub(crate) arrays: Vec<Array>,
    /// Arrays at cells, and those that say what the cells are.
    pub(crate) cell_arrays: Vec<Array>,
    cells: Vec<Array>,
}

impl Piece {
    /// Returns the array of coordinates.
    pub(crate) fn points(&self) -> Result<&Array, FieldError> {
        self.points.as_ref().ok_or_else(|| fault("a piece has no points"))
    }

    /// Returns an array of the cells by its name.
    pub(crate) fn cells(&self, name: &str) -> Result<&Array, FieldError> {
        let found = self.cells.iter().find(|array| array.name == name);
        found.ok_or_else(|| fault(format!("a piece has no array \"{name}\" of its cells")))
    }
}

impl Array {
    /// Tells whether it holds whole numbers.
    pub(crate) fn is_whole(&self) -> bool {
        self.kind.starts_with("Int") || self.kind.starts_with("UInt")
    }
}

/// A file with the appended bytes behind its `_`.
pub(crate) struct Document<'a> {
    pub(crate) pieces: Vec<Piece>,
    big_endian: bool,
    /// Bytes of the numbers in front of data: 4 or 8.
    header: usize,
    compressed: bool,
    appended: &'a [u8],
    appended_is_raw: bool,
}

/// Attributes of a tag.
type Attributes = HashMap<String, String>;

/// Splits a tag without its brackets into its name and its attributes.
fn tag(text: &str) -> (&str, Attributes) {
    let (name, mut rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    let mut attributes = Attributes::new();
    while let Some((key, after)) = rest.split_once('=') {
        let after = after.trim_start();
        let Some(quote) = after.chars().next().filter(|c| matches!(c, '"' | '\'')) else { break };
        let Some((value, after)) = after[1..].split_once(quote) else { break };
        attributes.insert(key.trim().to_owned(), value.to_owned());
        rest = after;
    }
    (name.trim_end_matches('/'), attributes)
}

fn position(bytes: &[u8], word: &[u8]) -> Option<usize> {
    bytes.windows(word.len()).position(|w| w == word)
}

impl<'a> Document<'a> {
    /// Reads the head of a file.
    pub(crate) fn new(bytes: &'a [u8]) -> Result<Self, FieldError> {
        let start = position(bytes, b"<AppendedData");
        let (head, tail) = bytes.split_at(start.unwrap_or(bytes.len()));
        let begin = position(tail, b"_").map_or(tail.len(), |k| k + 1);
        let raw = position(&tail[..begin], b"raw").is_some();
        let mut file = Self {
            pieces: Vec::new(),
            big_endian: false,
            header: 4,
            compressed: false,
            appended: &tail[begin..],
            appended_is_raw: raw,
        };
        let text = String::from_utf8_lossy(head);
        let mut section = String::new();
        let mut known = false;
        for part in text.split('<').skip(1) {
            let Some((inside, content)) = part.split_once('>') else { continue };
            let (name, attributes) = tag(inside.trim());
            let get = |key: &str| attributes.get(key).map(String::as_str).unwrap_or_default();
            match name {
                "VTKFile" => {
                    known = get("type") == "UnstructuredGrid";
                    file.big_endian = get("byte_order") == "BigEndian";
                    file.header = if get("header_type") == "UInt64" { 8 } else { 4 };
                    file.compressed = match get("compressor") {
                        "" => false,
                        "vtkZLibDataCompressor" => true,
                        other => {
                            return Err(fault(format!("it is compressed by {other}, and only zlib is read")));
                        }
                    };
                }
                "Piece" => {
                    let count = get("NumberOfPoints")
                        .parse()
                        .map_err(|_| fault("a piece without a number of points"))?;
                    let cell_count = get("NumberOfCells").parse().unwrap_or(0);
                    file.pieces.push(Piece { count, cell_count, ..Piece::default() });
                }
                "Points" | "PointData" | "CellData" | "Cells" => section = name.to_owned(),
                "DataArray" => {
                    let source = match get("format") {
                        "appended" => Source::Appended(
                            get("offset").parse().map_err(|_| fault("an array without an offset"))?,
                        ),
                        "binary" => Source::Base64(content.split_whitespace().collect()),
                        _ => Source::Text(content.to_owned()),
                    };
                    let components = get("NumberOfComponents").parse().unwrap_or(1);
                    let array = Array {
                        name: get("Name").to_owned(),
                        kind: get("type").to_owned(),
                        components,
                        source,
                    };
                    if let Some(piece) = file.pieces.last_mut() {
                        match section.as_str() {
                            "Points" => piece.points = Some(array),
                            "PointData" => piece.arrays.push(array),
                            "CellData" => piece.cell_arrays.push(array),
                            "Cells" => piece.cells.push(array),
                            _ => {}
                        }
                    }
                }
                _ => {}
            }
        }
        if known { Ok(file) } else { Err(fault("it is not an unstructured grid of VTK XML")) }
    }

    /// Decodes an array of real numbers.
    ///
    /// * `expected`: how many numbers; compressed data that are longer are not inflated further.
    pub(crate) fn reals(&self, array: &Array, expected: usize) -> Result<Vec<f64>, FieldError> {
        let bytes = match self.data(array, expected)? {
            Data::Text(words) => return parsed(words),
            Data::Bytes(bytes) => bytes,
        };
        let words = |size: usize| bytes.chunks_exact(size).map(|word| self.whole(word));
        match array.kind.as_str() {
            "Float64" => Ok(words(8).map(f64::from_bits).collect()),
            "Float32" => Ok(words(4).map(|bits| f64::from(f32::from_bits(bits as u32))).collect()),
            other => Err(fault(format!(
                "the array \"{}\" is of type {other}; Float32 or Float64 are read",
                array.name
            ))),
        }
    }

    /// Decodes an array of whole numbers, see [`Self::reals`].
    pub(crate) fn integers(&self, array: &Array, expected: usize) -> Result<Vec<i64>, FieldError> {
        let bytes = match self.data(array, expected)? {
            Data::Text(words) => return parsed(words),
            Data::Bytes(bytes) => bytes,
        };
        let digits = array.kind.trim_start_matches('U').strip_prefix("Int");
        let Some(size) =
            digits.and_then(|bits| bits.parse().ok()).filter(|bits| [8, 16, 32, 64].contains(bits))
        else {
            let found =
                format!("the array \"{}\" is of type {}; Int8 to UInt64 are read", array.name, array.kind);
            return Err(fault(found));
        };
        // Shifting up and down again extends the sign.
        let (unused, signed) = (64 - size, array.kind.starts_with('I'));
        let number = |word: &[u8]| match (self.whole(word) << unused, signed) {
            (high, true) => high as i64 >> unused,
            (high, false) => (high >> unused) as i64,
        };
        Ok(bytes.chunks_exact(size / 8).map(number).collect())
    }

    /// Finds the data of an array, decoded and inflated.
    fn data<'b>(&self, array: &'b Array, expected: usize) -> Result<Data<'b>, FieldError> {
        let most = expected.saturating_mul(size_of::<f64>());
        let bytes = match &array.source {
            Source::Text(text) => return Ok(Data::Text(text)),
            Source::Base64(text) => self.payload(&decoded(text.as_bytes())?, most)?,
            Source::Appended(offset) => {
                let rest = self
                    .appended
                    .get(*offset..)
                    .ok_or_else(|| fault("an array begins behind the end of the file"))?;
                if self.appended_is_raw {
                    self.payload(rest, most)?
                } else {
                    self.payload(&decoded(rest)?, most)?
                }
            }
        };
        Ok(Data::Bytes(bytes))
    }

    /// Reads a number in front of data.
    fn size(&self, bytes: &[u8], at: usize) -> Result<usize, FieldError> {
        let word = bytes
            .get(at * self.header..(at + 1) * self.header)
            .ok_or_else(|| fault("the data are cut off"))?;
        usize::try_from(self.whole(word)).map_err(|_| fault("the data are cut off"))
    }

    /// Returns the whole number that up to eight bytes are.
    fn whole(&self, bytes: &[u8]) -> u64 {
        let join = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
        if self.big_endian { bytes.iter().fold(0, join) } else { bytes.iter().rev().fold(0, join) }
    }

    /// Takes the data behind their sizes, and inflates them.
    ///
    /// * `most`: how many bytes compressed data may become.
    fn payload(&self, bytes: &[u8], most: usize) -> Result<Vec<u8>, FieldError> {
        let cut = || fault("the data are cut off");
        if !self.compressed {
            let size = self.size(bytes, 0)?;
            let end = self.header.checked_add(size).ok_or_else(cut)?;
            return Ok(bytes.get(self.header..end).ok_or_else(cut)?.to_vec());
        }
        let blocks = self.size(bytes, 0)?;
        // Each block has at least one byte.
        if blocks > bytes.len() {
            return Err(cut());
        }
        let mut at = (3 + blocks) * self.header;
        let mut data = Vec::new();
        for block in 0..blocks {
            let end = at.checked_add(self.size(bytes, 3 + block)?).ok_or_else(cut)?;
            let packed = bytes.get(at..end).ok_or_else(cut)?;
            let inflated = decompress_to_vec_zlib_with_limit(packed, most - data.len());
            data.extend(
                inflated.map_err(|error| fault(format!("its compressed data are damaged: {error}")))?,
            );
            at = end;
        }
        Ok(data)
    }
}

/// The numbers of an array: text, or bytes in the order of the file.
enum Data<'a> {
    Text(&'a str),
    Bytes(Vec<u8>),
}

/// Reads the numbers of a text.
fn parsed<T: FromStr>(text: &str) -> Result<Vec<T>, FieldError> {
    let number = |word: &str| word.parse().map_err(|_| fault(format!("\"{word}\" is not a number")));
    text.split_whitespace().map(number).collect()
}

/// Decodes base64 text up to the first other character; parts that are encoded for themselves follow each other.
fn decoded(text: &[u8]) -> Result<Vec<u8>, FieldError> {
    let is_code = |b: &&u8| b.is_ascii_alphanumeric() || matches!(b, b'+' | b'/' | b'=');
    let code: Vec<u8> = text.iter().take_while(is_code).copied().collect();
    let mut bytes = Vec::with_capacity(code.len() / 4 * 3);
    let mut rest = code.as_slice();
    while !rest.is_empty() {
        // A part ends with its padding.
        let end = rest.iter().position(|b| *b == b'=').map_or(rest.len(), |k| (k + 4) / 4 * 4);
        let (part, after) = rest.split_at(end.min(rest.len()));
        let found =
            STANDARD.decode(part).map_err(|error| fault(format!("its base64 data are damaged: {error}")))?;
        bytes.extend(found);
        rest = after;
    }
    Ok(bytes)
}
