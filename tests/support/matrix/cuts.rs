//! Cuts through blocks: a given shortening, or the force of one.

use super::draw::Draw;
use super::runs::{CaseText, Quiet, run};
use crate::model::Made;
use crate::random::Random;

/// The features.
pub(super) const SHORTENED: &str = "cut: shortening";
pub(super) const TIGHTENED: &str = "cut: force";

/// One of this many problems has a cut.
const SELDOM: usize = 8;
/// The least change of the force by the shortening, relative; forces that are rounding do not change.
const CHANGE: f64 = 1e-3;
/// At most this many places are tried.
const TRIALS: usize = 4;

/// Cuts a block of some problems, if the program allows it. They have random numbers of their own, so that the other problems keep theirs. Returns
/// whether there is a cut.
///
/// # Errors
/// Files that cannot be written.
pub(super) fn put(d: &mut Draw, number: u64) -> Made<bool> {
    let mut random = Random::new(1_000_003 * number + 97);
    if random.integer(1, SELDOM) > 1 {
        return Ok(false);
    }
    let text = d.bodies().to_owned();
    let tables: Vec<&str> = text.split_inclusive("[[body]]\n").collect();
    let blocks: Vec<usize> = (0..tables.len()).filter(|k| tables[*k].contains("kind = \"block\"")).collect();
    for _ in 0..if blocks.is_empty() { 0 } else { TRIALS } {
        let chosen = blocks[random.integer(0, blocks.len() - 1)];
        let Some(plane) = plane(tables[chosen], &mut random) else { continue };
        let shortening = d.strain * d.length * random.signed();
        let table = |load: &str| format!("[[body.cut]]\nname = \"bolt\"\nplane = {plane}\n{load}\n");
        let with = |load: &str| {
            let cut = |(k, body): (usize, &&str)| match body.strip_suffix("[[body]]\n") {
                Some(own) if k == chosen => format!("{own}{}[[body]]\n", table(load)),
                None if k == chosen => format!("{body}{}", table(load)),
                _ => (*body).to_owned(),
            };
            tables.iter().enumerate().map(cut).collect::<String>()
        };
        d.replace_bodies(with(&format!("shortening = {:?}", 2.0 * shortening)));
        let Some(other) = force(d)? else { continue };
        d.replace_bodies(with(&format!("shortening = {shortening:?}")));
        let Some(force) = force(d)? else { continue };
        // Loads alone determine the force in what nothing holds, at any shortening.
        let least = CHANGE * force.abs().max(1e-6 * d.stress * d.strain * d.length);
        let changes = (other - force).abs() > least;
        if changes && random.unit() < 0.7 {
            d.replace_bodies(with(&format!("force = {force:?}")));
            d.mark(TIGHTENED);
        } else {
            d.mark(SHORTENED);
        }
        return Ok(true);
    }
    d.replace_bodies(text);
    Ok(false)
}

/// Draws a plane between two rows of cells of a block; `None` if it has too few.
fn plane(body: &str, random: &mut Random) -> Option<String> {
    let numbers = |key: &str| -> Option<Vec<f64>> {
        let list = body.split_once(&format!("{key} = ["))?.1.split_once(']')?.0;
        list.split(',').map(|x| x.trim().parse().ok()).collect()
    };
    let (origin, size, cells) = (numbers("origin")?, numbers("size")?, numbers("cells")?);
    let axis = random.integer(0, 1);
    if cells[axis] < 3.0 {
        return None;
    }
    let row = random.integer(1, cells[axis] as usize - 1) as f64;
    let at = |k: usize| if k == axis { origin[k] + size[k] * row / cells[k] } else { origin[k] };
    let sign = if random.unit() < 0.5 { 1.0 } else { -1.0 };
    let normal = [0, 1].map(|k| if k == axis { sign * (0.5 + random.unit()) } else { 0.0 });
    Some(format!("{{ point = [{:?}, {:?}], normal = {normal:?} }}", at(0), at(1)))
}

/// Computes the force in the cut of the problem as it is; `None` if the program refuses it, or finds no answer.
fn force(d: &Draw) -> Made<Option<f64>> {
    let folder = tempfile::tempdir()?;
    for (name, bytes) in &d.files {
        std::fs::write(folder.path().join(name), bytes)?;
    }
    let source = CaseText { text: d.text(&[]), folder: folder.path().to_owned() };
    let found = run(&source, &folder.path().join("out"), &mut Quiet::new());
    let done = found.ok().filter(|done| done.report.status.code == 0);
    let cuts = done.and_then(|done| done.report.results.cuts);
    Ok(cuts.and_then(|cuts| cuts.first().map(|cut| cut.force)))
}
