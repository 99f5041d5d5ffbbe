//! Every setting with its value, in the case file's own structure, and the hash that names a case.

use super::{BodyCase, Case, Contact, Dimension, OutputPath, SCHEMA, read_contact};
use serde::Serialize;
use serde_json::{Map, Value as Json, json};
use sha2::{Digest, Sha256};

/// The path of the single table.
const SINGLE: &str = "contact";

impl<S: Dimension> Case<S> {
    /// Returns every setting with its value, as written or by default: the `case` object of report.json.
    pub fn settings_json(&self) -> Json {
        let materials: Map<String, Json> =
            self.materials.iter().map(|m| (m.name.clone(), m.json())).collect();
        let mut settings = json!({
            "schema": SCHEMA,
            "title": self.title,
            "model": self.model_json(),
            "materials": materials,
            "body": self.bodies.iter().map(body).collect::<Vec<_>>(),
            "contact": self.contact_json(),
            "solver": self.solver,
            "estimator": self.estimator_json(),
        });
        insert(&mut settings, "units", self.units.as_ref());
        insert(&mut settings, "adapt", self.adapt.as_ref());
        insert(&mut settings, "step", (!self.steps.is_empty()).then_some(&self.steps));
        settings["output"] = json!({ "directory": self.output_directory(), "vtu": self.output.vtu });
        if !self.paths.is_empty() {
            settings["output"]["path"] = self.paths.iter().map(OutputPath::json).collect();
        }
        settings["limits"] = json!({
            "memory": self.limits.memory.as_ref().map(|l| &l.written),
            "time": self.limits.time.as_ref().map(|l| &l.written),
        });
        settings
    }

    /// Returns what decides every number that a run computes: the settings less title, units, output and limits, and the contents
    /// of the mesh files that were read, by their SHA-256.
    pub fn identity(&self) -> Json {
        let mut settings = self.settings_json();
        if let Some(settings) = settings.as_object_mut() {
            for key in ["title", "units", "output", "limits"] {
                settings.remove(key);
            }
        }
        // A mesh file counts by its contents.
        if self.meshes.digests().iter().any(Option::is_some) {
            settings["meshes"] = json!(self.meshes.digests());
        }
        settings
    }

    fn model_json(&self) -> Json {
        let mut model = S::model_json(&self.model);
        if let Some(inertia) = &self.inertia {
            inertia.json(&mut model);
        }
        model
    }

    /// An object if it was written as the single table, which two bodies may have; an array otherwise.
    fn contact_json(&self) -> Json {
        let of = |given: &Contact<S>| contact(given, &self.bodies);
        match self.contacts.as_slice() {
            [only] if only.path == SINGLE => of(only),
            all => all.iter().map(of).collect(),
        }
    }

    fn estimator_json(&self) -> Json {
        let every = self.estimator.every;
        match self.estimator.until {
            None => json!({ "relaxation": self.estimator.relaxation, "every": every }),
            Some(until) => {
                json!({ "tolerance": until.tolerance, "max_steps": until.max_steps, "every": every })
            }
        }
    }

    /// Computes the SHA-256 of [`Case::identity`], in hexadecimal: the hash of two runs of the same case does
    /// not depend on their output, title, limits, layout or comments.
    pub fn hash(&self) -> String {
        let mut settings = self.identity();
        settings.sort_all_objects();
        let digest = Sha256::digest(settings.to_string().as_bytes());
        digest.iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

fn body<S: Dimension>(body: &BodyCase<S>) -> Json {
    let (key, mesh) = body.mesh.json();
    let mut settings = json!({
        "name": body.name,
        "material": body.material,
        key: mesh,
        "body_force": body.body_force.as_ref(),
        "displacement": body.displacements,
        "traction": body.tractions,
    });
    insert(&mut settings, "temperature", (!body.temperatures.is_empty()).then_some(&body.temperatures));
    insert(&mut settings, "side", (!body.sides.is_empty()).then_some(&body.sides));
    insert(&mut settings, "rigid", (!body.rigid.is_empty()).then_some(&body.rigid));
    insert(&mut settings, "spring", (!body.springs.is_empty()).then_some(&body.springs));
    insert(&mut settings, "cut", (!body.cuts.is_empty()).then_some(&body.cuts));
    insert(&mut settings, S::CURVE_TABLE, (!body.curves.is_empty()).then_some(&body.curves));
    insert(&mut settings, "region", (!body.regions.is_empty()).then_some(&body.regions));
    settings
}

fn contact<S: Dimension>(given: &Contact<S>, bodies: &[BodyCase<S>]) -> Json {
    let gap = if given.geometric { json!(read_contact::GEOMETRIC) } else { json!(given.gap) };
    let mut object = json!({ "surfaces": given.surfaces });
    insert(&mut object, "gap", given.bond.is_none().then_some(gap));
    if given.path != SINGLE || given.named {
        object["name"] = json!(given.name);
    }
    if given.path != SINGLE {
        object["bodies"] = given.bodies.iter().map(|b| json!(bodies[*b].name)).collect();
    }
    insert(&mut object, "interference", given.interference.then_some(true));
    insert(&mut object, "obstacle", given.obstacle.as_ref());
    insert(&mut object, "normal", given.normal.as_ref().map(|normal| normal.as_ref()));
    insert(&mut object, "imposed", given.imposed);
    insert(&mut object, "friction", given.friction.as_ref());
    insert(&mut object, "law", given.bond.as_ref().map(|_| read_contact::BONDED));
    insert(&mut object, "offset", given.bond.as_ref().map(|offset| offset.as_ref()));
    object
}

/// Adds an entry to an object, if there is one.
fn insert(object: &mut Json, key: &str, value: Option<impl Serialize>) {
    if let Some(value) = value {
        object[key] = json!(value);
    }
}
