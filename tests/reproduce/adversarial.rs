//! Random problems made to break the bound, each against an admissible field of a finer mesh; exact ones; sharpness.

use crate::page::{Counts, head, median, write};
use crate::{exact, sharpness};
use rayon::prelude::*;
use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;
use tests::adversarial::Family;
use tests::trial::Trial;

/// Members of each family.
const MEMBERS: u64 = 180;
/// Formats the smallest, the middle and the largest effectivity.
fn spread(found: &[Trial], bound: usize) -> String {
    let mut all: Vec<f64> = found.iter().filter_map(|s| s.effectivity(bound)).collect();
    let middle = median(&mut all);
    let ends = [all.first(), all.last()].map(|x| x.copied().unwrap_or(f64::NAN));
    format!("{:.3} / {middle:.3} / {:.3}", ends[0], ends[1])
}

/// Largest effectivity that is certain: against the largest error that the finer solution's own bound leaves.
fn certain(found: &[Trial]) -> f64 {
    found.iter().filter(|s| s.error.is_some()).map(|s| s.bounds[1] / s.largest).fold(0.0, f64::max)
}

/// Makes the tables; writes `adversarial.csv` and `exact.csv`; fails if anything is violated.
pub(crate) fn page(folder: &Path, quick: bool) -> Result<(), Box<dyn Error>> {
    let members = if quick { MEMBERS / 10 } else { MEMBERS };
    let mut text = head(&[
        "family",
        "problems",
        "without certificate",
        "without finer field",
        "e_CRE, two steps",
        "e_CRE, default",
        "eta_nndd",
        "energy norm",
        "potential energy",
        "contact force",
        "effectivity, two steps",
        "effectivity, default",
        "largest that is certain",
    ]) + "\n";
    let mut csv = String::from(
        "family,number,nodes,norm,two_steps,default,error,largest_error,eta_nndd,discrete_error,v_two,v_default,v_eta,v_norm,v_energy,v_force\n",
    );
    let (mut count, mut violated) = (0, 0);
    let (mut counts, earlier) = (Counts::default(), Counts::read(folder, "before.csv"));
    for family in Family::ALL {
        let one =
            |number: u64| Trial::new(family, number).map_err(|e| format!("{} {number}: {e}", family.name()));
        let found: Result<Vec<Option<Trial>>, String> = (0..members).into_par_iter().map(one).collect();
        let found: Vec<Trial> = found?.into_iter().flatten().collect();
        count += found.len();
        let alone = found.iter().filter(|s| s.error.is_none()).count();
        let violations: [usize; 6] =
            std::array::from_fn(|k| found.iter().filter(|s| s.violations[k]).count());
        violated += violations.iter().sum::<usize>();
        let mut cells = vec![
            family.name().to_owned(),
            found.len().to_string(),
            (members as usize - found.len()).to_string(),
            alone.to_string(),
        ];
        cells.extend(counts.add(family.name(), &violations, &earlier));
        cells.extend([spread(&found, 0), spread(&found, 1), format!("{:.3}", certain(&found))]);
        let _ = writeln!(text, "| {} |", cells.join(" | "));
        for s in &found {
            let flags = s.violations.map(|v| u8::from(v).to_string()).join(",");
            let error = s.error.unwrap_or(f64::NAN);
            let name = family.name().replace(',', "");
            let _ = writeln!(
                csv,
                "{name},{},{},{:e},{:e},{:e},{error:e},{:e},{:e},{:e},{flags}",
                s.number, s.nodes, s.norm, s.bounds[0], s.bounds[1], s.largest, s.eta[0], s.eta[1]
            );
        }
    }
    let (layers, layers_csv, more) = exact::section(quick, &mut counts, &earlier)?;
    write(folder, "adversarial.csv", &csv)?;
    write(folder, "exact.csv", &layers_csv)?;
    write(folder, "violations.csv", &counts.csv())?;
    println!(
        "## Random problems: {count}\n\n{text}\n## Exact solutions\n\n{layers}\n{}",
        sharpness::section(quick)?
    );
    match violated + more {
        0 => Ok(()),
        all => Err(format!("{all} violations").into()),
    }
}
