//! Lines of sets and surfaces.

use super::data::{self, DataLine};
use super::sets::{Entry, Face, Target};

/// Reads a line of a set: numbers and names, or a range.
pub(super) fn set_entries(row: &DataLine<'_>, generate: bool) -> Result<Vec<Entry>, data::Fault> {
    if generate {
        let mut numbers = Vec::new();
        row.numbers(&mut numbers)?;
        return match numbers[..] {
            [from, to] if from <= to => Ok(vec![Entry::Range { from, to, step: 1 }]),
            [from, to, step] if from <= to && step > 0 => Ok(vec![Entry::Range { from, to, step }]),
            _ => Err(data::Fault::new(
                format!("{} do not make a range", data::listed(&numbers)),
                "first, last, step: first <= last and step >= 1",
            )),
        };
    }
    row.fields()
        .map(|field| {
            let text = data::text(field);
            match data::number(field) {
                Some(number) => Ok(Entry::Range { from: number, to: number, step: 1 }),
                None if text.is_empty() => {
                    Err(data::Fault::new("an entry is empty".to_owned(), "a number or the name of a set"))
                }
                None => Ok(Entry::Name(data::unquoted(&text).to_owned())),
            }
        })
        .collect()
}

/// Reads a line of a surface.
pub(super) fn surface_entry(row: &DataLine<'_>, of_nodes: bool) -> Result<(Target, Face), data::Fault> {
    let fields: Vec<&[u8]> = row.fields().collect();
    let Some((first, rest)) = fields.split_first() else {
        return Err(data::Fault::new("the line is empty".to_owned(), "a set or number and a face"));
    };
    let target = match data::number(first) {
        Some(number) => Target::Number(number),
        None => Target::Name(data::unquoted(&data::text(first)).to_owned()),
    };
    if of_nodes {
        return Ok((target, Face::Whole));
    }
    let face = rest.first().map(|f| data::text(f).to_uppercase());
    let face = face.as_deref();
    match face.and_then(Face::parse) {
        Some(face) => Ok((target, face)),
        None => Err(data::Fault::new(
            format!("the face of a surface is {}", face.map_or("missing".to_owned(), |f| format!("`{f}`"))),
            "S1 to S6 after the element or set, for shells also E1 to E4",
        )),
    }
}
