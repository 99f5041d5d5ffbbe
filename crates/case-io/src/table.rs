//! The CSV files: history, contact, adaptive steps and sweep. Numbers are in the shortest form that reads back
//! exactly; an unknown value is an empty field.

use crate::report::{AdaptiveRow, IterationRow, NotFinite, SweepPanel, check_finite};
use serde::Serialize;
use thiserror::Error;

/// The columns of history.csv: the keys of `iterations` in report.json, of which `contact_forces` takes two columns.
const HISTORY_COLUMNS: [&str; 14] = [
    "iteration",
    "theta",
    "precision",
    "eta_nndd",
    "eta_dis",
    "e_cre",
    "contact_nodes",
    "contact_force",
    "contact_forces_first",
    "contact_forces_second",
    "qp_path",
    "qp_iterations",
    "step",
    "inner",
];

/// The columns of contact.csv in the plane and, without `s`, of solids.
const CONTACT_COLUMNS: [&str; 8] = ["s", "x", "y", "z", "gap", "opening", "pressure", "active"];

/// The columns of contact.csv with friction in the plane, and of solids.
const FRICTION_COLUMNS: [&str; 4] = ["tangential", "slip", "limit", "state"];
const SOLID_FRICTION_COLUMNS: [&str; 8] =
    ["tangential_x", "tangential_y", "tangential_z", "slip_x", "slip_y", "slip_z", "limit", "state"];

/// The columns of adaptive.csv: the keys of `adaptive` in report.json.
const ADAPTIVE_COLUMNS: [&str; 8] =
    ["step", "nodes", "pairs", "e_cre", "relative", "iterations", "energy_norm_squared", "peak_stress"];

/// Why a table cannot be written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum TableError {
    /// A number that is infinite or NaN.
    #[error("row {row} of the table: {field} is {value}; only finite numbers are written")]
    NotFinite {
        /// Row, from 1.
        row: usize,
        /// Column.
        field: String,
        /// The number.
        value: f64,
    },
    /// An error of the CSV writer.
    #[error("the table cannot be written: {0}")]
    Csv(#[from] csv::Error),
}

/// One node pair of the interface.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ContactRow {
    /// Arc length along the first body's surface, m; left out of solids.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub s: Option<f64>,
    /// Position, m.
    pub x: f64,
    /// Position, m.
    pub y: f64,
    /// Position, m; left out in the plane.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub z: Option<f64>,
    /// Initial gap, m, ≥ 0: datum of the problem.
    pub gap: f64,
    /// Current opening, m, ≥ 0: the gap less the approach of the two bodies.
    pub opening: f64,
    /// Pressure, Pa, ≥ 0 in compression.
    pub pressure: f64,
    /// 1 in contact, 0 open.
    pub active: u8,
    /// Pressure recovered over the cells of the coarser side, Pa; `None` if the nodes matched from the first mesh on.
    #[serde(skip)]
    pub pressure_recovered: Option<f64>,
    /// Friction at the pair; `None` without friction.
    #[serde(skip)]
    pub friction: Option<FrictionRow>,
    /// The load step, from 1; `None` without load steps.
    #[serde(skip)]
    pub step: Option<usize>,
}

impl ContactRow {
    /// Returns the arc length, m; 0 of solids.
    pub fn arc_length(&self) -> f64 {
        self.s.unwrap_or_default()
    }
}

/// Friction at one node pair of the interface.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FrictionRow {
    /// Friction traction on the second body along the tangent `(−n_y, n_x)`, Pa; of solids its size.
    pub tangential: f64,
    /// Slip of the first body against the second along the tangent, m; of solids its size.
    pub slip: f64,
    /// Of solids both as vectors, Pa and m.
    pub in_space: Option<[[f64; 3]; 2]>,
    /// Largest friction traction, Pa: the given one, or `μ p`.
    pub limit: f64,
    /// `stick`, `slip` or `open`.
    pub state: String,
}

/// The displacement and the recovered stress at a point of a path.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PathRow {
    /// Length along the path, m.
    pub s: f64,
    /// Position, m: one number for each axis.
    pub place: Vec<f64>,
    /// The values there; `None` outside of all bodies.
    pub found: Option<PathValues>,
}

/// The values of a body at a point of a path.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PathValues {
    /// Name of the body.
    pub body: String,
    /// Displacement, m: one number for each axis.
    pub displacement: Vec<f64>,
    /// Recovered stress, Pa, tension positive: xx, yy, zz, xy, and of solids yz, xz.
    pub stress: Vec<f64>,
    /// Its equivalent stress, Pa; `None` if the constants of the material do not say it.
    pub von_mises: Option<f64>,
    /// Its smallest and its largest principal stress, Pa; in the plane those in the plane.
    pub principal: [f64; 2],
}

/// Writes path-NAME.csv.
///
/// # Errors
/// A number that is not finite.
pub fn path_csv(rows: &[PathRow]) -> Result<String, TableError> {
    let axes = rows.first().map_or(2, |row| row.place.len());
    let stresses = ["stress_xx", "stress_yy", "stress_zz", "stress_xy", "stress_yz", "stress_xz"];
    let mut columns = vec!["s"];
    columns.extend(&["x", "y", "z"][..axes]);
    columns.push("body");
    columns.extend(&["ux", "uy", "uz"][..axes]);
    columns.extend(&stresses[..2 * axes]);
    columns.extend(["von_mises", "principal_smallest", "principal_largest"]);
    let cells = |row: &PathRow| {
        let mut numbers = vec![None; 3 * axes + 3];
        if let Some(found) = &row.found {
            let stress = found.displacement.iter().chain(&found.stress).map(|x| Some(*x));
            let rest = [found.von_mises, Some(found.principal[0]), Some(found.principal[1])];
            numbers = stress.chain(rest).collect();
        }
        (row.s, row.place.clone(), row.found.as_ref().map(|found| found.body.clone()), numbers)
    };
    write(&columns, &rows.iter().map(cells).collect::<Vec<_>>())
}

/// Writes history.csv.
///
/// # Errors
/// A number that is not finite.
pub fn history_csv(rows: &[IterationRow]) -> Result<String, TableError> {
    write(&HISTORY_COLUMNS, rows)
}

/// Writes contact.csv.
///
/// * `pairs`: the rows of each pair in each load step, with its name, which is written if there are several.
///
/// # Errors
/// A number that is not finite.
pub fn contact_csv(pairs: &[(&str, Vec<ContactRow>)]) -> Result<String, TableError> {
    // Under the names of their columns.
    for (k, row) in pairs.iter().flat_map(|(_, rows)| rows).enumerate() {
        finite(k, row)?;
        finite(k, &row.friction)?;
        finite(k, &row.pressure_recovered)?;
    }
    let several = pairs.iter().any(|(name, _)| *name != pairs[0].0);
    let with_friction = pairs.iter().flat_map(|(_, rows)| rows).any(|row| row.friction.is_some());
    let of_solids = pairs.iter().flat_map(|(_, rows)| rows).any(|row| row.z.is_some());
    let foreign = if of_solids { "s" } else { "z" };
    let mut columns: Vec<&str> = CONTACT_COLUMNS.into_iter().filter(|name| *name != foreign).collect();
    // The name is the first column of solids, and in the plane one of several pairs.
    let named = several && !of_solids;
    columns.splice(0..0, of_solids.then_some("pair"));
    columns.extend(named.then_some("pair"));
    if with_friction {
        let of_friction =
            if of_solids { SOLID_FRICTION_COLUMNS.as_slice() } else { FRICTION_COLUMNS.as_slice() };
        columns.extend(of_friction);
    }
    let recovered = pairs.iter().flat_map(|(_, rows)| rows).any(|row| row.pressure_recovered.is_some());
    columns.extend(recovered.then_some("pressure_recovered"));
    let in_steps = pairs.iter().flat_map(|(_, rows)| rows).any(|row| row.step.is_some());
    columns.extend(in_steps.then_some("step"));
    let cells = |(name, row): (&&str, &ContactRow)| {
        // Pairs without friction leave its columns empty; an empty vector has no column.
        let of = row.friction.as_ref();
        let vectors = of.and_then(|f| f.in_space);
        let mut numbers: Vec<Option<f64>> = match of_solids {
            true => (0..6).map(|k| vectors.map(|both| both[k / 3][k % 3])).collect(),
            false => vec![of.map(|f| f.tangential), of.map(|f| f.slip)],
        };
        numbers.push(of.map(|f| f.limit));
        let state = of.map_or_else(String::new, |f| f.state.clone());
        let if_any = |used: bool, text: String| if used { vec![text] } else { vec![] };
        (
            if_any(of_solids, (*name).to_owned()),
            row.clone(),
            if_any(named, (*name).to_owned()),
            if with_friction { numbers } else { vec![] },
            if_any(with_friction, state),
            if recovered { vec![row.pressure_recovered] } else { vec![] },
            if in_steps { vec![row.step] } else { vec![] },
        )
    };
    let rows = pairs.iter().flat_map(|(name, rows)| rows.iter().map(move |row| (name, row)));
    write(&columns, &rows.map(cells).collect::<Vec<_>>())
}

/// Writes adaptive.csv, with Coulomb friction with the residual in place of the bound.
///
/// # Errors
/// A number that is not finite.
pub fn adaptive_csv(rows: &[AdaptiveRow]) -> Result<String, TableError> {
    let residuals = rows.iter().any(|row| row.e_b.is_some());
    let of_row = |row: &AdaptiveRow| {
        let [error, relative] =
            if residuals { [row.e_b, row.relative_residual] } else { [row.e_cre, row.relative] };
        let sizes = (row.step, row.nodes, row.pairs);
        (sizes, error, relative, row.iterations, row.energy_norm_squared, row.peak_stress)
    };
    let mut columns = ADAPTIVE_COLUMNS;
    if residuals {
        [columns[3], columns[4]] = ["e_b", "relative_residual"];
    }
    // Under the names of their columns.
    rows.iter().enumerate().try_for_each(|(k, row)| finite(k, row))?;
    write(&columns, &rows.iter().map(of_row).collect::<Vec<_>>())
}

/// Writes sweep.csv: the swept key, `status`, `valid`, the keys of `iterations` of each run's last iteration, and then which panel
/// it is, the same in every row: its name and its settings.
///
/// # Errors
/// A number that is not finite.
pub fn sweep_csv(key: &str, panel: &SweepPanel) -> Result<String, TableError> {
    let mut columns = vec![key, "status", "valid"];
    columns.extend(HISTORY_COLUMNS);
    columns.extend(["panel", "settings", "round_off"]);
    let settings = panel.settings.join("; ");
    let rows = panel.rows.iter();
    let tuples: Vec<_> = rows
        .map(|r| (&r.value, &r.status, r.valid, &r.iteration, &panel.name, &settings, r.round_off))
        .collect();
    write(&columns, &tuples)
}

/// Checks the numbers of row `k`, from 0.
fn finite<T: Serialize>(k: usize, row: &T) -> Result<(), TableError> {
    let fault =
        |fault: NotFinite| TableError::NotFinite { row: k + 1, field: fault.field, value: fault.value };
    check_finite(row).map_err(fault)
}

/// Writes the columns first, so that a table without rows has them too.
fn write<T: Serialize>(columns: &[&str], rows: &[T]) -> Result<String, TableError> {
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    writer.write_record(columns)?;
    for (k, row) in rows.iter().enumerate() {
        finite(k, row)?;
        writer.serialize(row)?;
    }
    let bytes = writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::SweepRow;

    #[test]
    fn history_has_the_keys_of_iterations() {
        let row = IterationRow {
            iteration: 1,
            theta: Some(0.4),
            eta_nndd: Some(0.1 + 0.2),
            contact_force: Some(1e-20),
            contact_forces: [Some(1e-20), None],
            qp_path: Some("active, set".into()),
            ..IterationRow::default()
        };
        let keys: Vec<String> =
            serde_json::to_value(&row).unwrap().as_object().unwrap().keys().cloned().collect();
        let columns = HISTORY_COLUMNS.map(|c| c.trim_end_matches("_first").to_owned());
        let columns: Vec<String> = columns.into_iter().filter(|c| !c.ends_with("_second")).collect();
        assert_eq!(keys, columns);
        let text = history_csv(std::slice::from_ref(&row)).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], HISTORY_COLUMNS.join(","));
        assert_eq!(lines[1], "1,0.4,,0.30000000000000004,,,0,1e-20,1e-20,,\"active, set\",0,,");
        // By position: the two forces are one field of a row.
        let records = csv::Reader::from_reader(text.as_bytes()).into_records();
        let back: Vec<IterationRow> = records.map(|r| r.unwrap().deserialize(None).unwrap()).collect();
        assert_eq!(back, [row]);
        assert_eq!(history_csv(&[]).unwrap().lines().count(), 1);
    }

    #[test]
    fn contact_has_its_columns() {
        let row = ContactRow {
            s: Some(0.5),
            x: 0.5,
            y: 1.0,
            z: None,
            gap: 0.25,
            opening: 0.0,
            pressure: 1234.5678901234567,
            active: 1,
            pressure_recovered: None,
            friction: None,
            step: None,
        };
        assert_eq!(
            contact_csv(&[("", vec![row.clone()])]).unwrap(),
            "s,x,y,gap,opening,pressure,active\n0.5,0.5,1.0,0.25,0.0,1234.5678901234567,1\n"
        );
        let friction =
            FrictionRow { tangential: -1.5, limit: 4.0, state: "stick".into(), ..FrictionRow::default() };
        let rubs = ContactRow { friction: Some(friction), pressure_recovered: Some(1230.0), ..row.clone() };
        assert_eq!(
            contact_csv(&[("a", vec![row]), ("b", vec![rubs])]).unwrap(),
            "s,x,y,gap,opening,pressure,active,pair,tangential,slip,limit,state,pressure_recovered\n\
             0.5,0.5,1.0,0.25,0.0,1234.5678901234567,1,a,,,,,\n\
             0.5,0.5,1.0,0.25,0.0,1234.5678901234567,1,b,-1.5,0.0,4.0,stick,1230.0\n"
        );
    }

    #[test]
    fn rows_of_solids_have_three_coordinates_and_no_arc_length() {
        let row = ContactRow { x: 0.5, z: Some(2.0), pressure: 7.0, ..ContactRow::default() };
        assert_eq!(
            contact_csv(&[("top", vec![row])]).unwrap(),
            "pair,x,y,z,gap,opening,pressure,active\ntop,0.5,0.0,2.0,0.0,0.0,7.0,0\n"
        );
    }

    #[test]
    fn adaptive_steps_have_the_keys_of_the_report() {
        let row = AdaptiveRow { step: 2, nodes: 900, e_cre: Some(0.25), ..AdaptiveRow::default() };
        let keys: Vec<String> =
            serde_json::to_value(&row).unwrap().as_object().unwrap().keys().cloned().collect();
        assert_eq!(keys, ADAPTIVE_COLUMNS);
        assert_eq!(adaptive_csv(&[row]).unwrap().lines().nth(1), Some("2,900,0,0.25,,0,0.0,"));
        let row = AdaptiveRow { step: 1, e_b: Some(0.5), ..AdaptiveRow::default() };
        let text = adaptive_csv(&[row]).unwrap();
        assert!(text.starts_with("step,nodes,pairs,e_b,relative_residual,iterations,"), "{text}");
        assert_eq!(text.lines().nth(1), Some("1,0,0,0.5,,0,0.0,"));
    }

    #[test]
    fn a_sweep_has_its_key_first() {
        let (value, status) = ("0.1".into(), "completed".into());
        let row = SweepRow { value, status, round_off: Some(0.5), ..SweepRow::default() };
        let settings = vec!["a=[1,2]".to_owned(), "b=3".to_owned()];
        let panel = SweepPanel { settings, name: "9 nodes".into(), nodes: 9, rows: vec![row] };
        let text = sweep_csv("solver.theta", &panel).unwrap();
        assert!(text.starts_with("solver.theta,status,valid,iteration,theta,"), "{text}");
        assert!(text.contains("\n0.1,completed,false,0,,"), "{text}");
        assert!(text.ends_with(",9 nodes,\"a=[1,2]; b=3\",0.5\n"), "{text}");
    }

    #[test]
    fn numbers_that_are_not_finite_are_refused() {
        let row = ContactRow { gap: f64::NAN, ..ContactRow::default() };
        let error = contact_csv(&[("", vec![ContactRow::default(), row])]).unwrap_err();
        assert!(error.to_string().starts_with("row 2 of the table: gap is NaN"), "{error}");
        let friction = Some(FrictionRow { slip: f64::INFINITY, ..FrictionRow::default() });
        let row = ContactRow { friction, ..ContactRow::default() };
        let error = contact_csv(&[("", vec![row])]).unwrap_err();
        assert!(error.to_string().starts_with("row 1 of the table: slip is inf"), "{error}");
    }
}
