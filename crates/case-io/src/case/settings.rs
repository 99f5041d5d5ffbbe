//! Every setting with its value, in the case file's own structure, and the hash that names a case.

use super::{
    BodyCase, Case, CellSelection, Contact, Displacement, Imposition, Load, MaterialRegion, MeshSource, Part,
    SCHEMA, Theta, Traction, Value, read,
};
use serde_json::{Map, Value as Json, json};
use sha2::{Digest, Sha256};

impl Case {
    /// Returns every setting with its value, as written or by default: the `case` object of report.json.
    pub fn settings_json(&self) -> Json {
        let materials: Map<String, Json> =
            self.materials.iter().map(|m| (m.name.clone(), m.json())).collect();
        let mut settings = json!({
            "schema": SCHEMA,
            "title": self.title,
            "model": {
                "hypothesis": read::hypothesis_name(self.model.hypothesis),
                "thickness": self.model.thickness,
            },
            "materials": materials,
            "body": self.bodies.iter().map(body).collect::<Vec<_>>(),
            "contact": contact(&self.contact),
            "solver": self.solver_json(),
            "estimator": self.estimator_json(),
        });
        if let Some(adapt) = &self.adapt {
            settings["adapt"] = json!({
                "target_relative_error": adapt.target_relative_error,
                "max_steps": adapt.max_steps,
                "max_nodes": adapt.max_nodes,
                "fraction": adapt.fraction,
            });
        }
        settings["output"] = json!({ "directory": self.output_directory(), "vtu": self.output.vtu });
        settings["limits"] = json!({
            "memory": self.limits.memory.as_ref().map(|l| &l.written),
            "time": self.limits.time.as_ref().map(|l| &l.written),
        });
        settings
    }

    /// Returns what decides every number that a run computes: the settings less title, output and limits, and the contents
    /// of the mesh files that were read, by their SHA-256.
    pub fn identity(&self) -> Json {
        let mut settings = self.settings_json();
        if let Some(settings) = settings.as_object_mut() {
            for key in ["title", "output", "limits"] {
                settings.remove(key);
            }
        }
        // A mesh file counts by its contents.
        if self.meshes.digests().iter().any(Option::is_some) {
            settings["meshes"] = json!(self.meshes.digests());
        }
        settings
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

    fn solver_json(&self) -> Json {
        let s = &self.solver;
        let mut stop = json!({ "criterion": s.stop.criterion.name(), "ratio": s.stop.ratio });
        if let Some(balance) = s.stop.force_balance {
            stop["force_balance"] = json!(balance);
        }
        stop["tolerance"] = json!(s.stop.tolerance);
        json!({
            "method": s.method.name(),
            "imposed": s.imposed.name(),
            "path": s.path.name(),
            "qp": s.qp.name(),
            "theta": match s.theta { Theta::Auto => json!("auto"), Theta::Value(theta) => json!(theta) },
            "weights": s.weights.name(),
            "acceleration": s.acceleration.name(),
            "lambda": value(&s.lambda),
            "max_iterations": s.max_iterations,
            "stop": stop,
        })
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

fn value(value: &Value) -> Json {
    match value {
        // Zero has one sign here, so that `-0.0` is the same case.
        Value::Number(number) => json!(number + 0.0),
        Value::Expression(expression) => json!(expression.text()),
    }
}

fn body(body: &BodyCase) -> Json {
    let (key, mesh) = mesh(&body.mesh);
    let mut settings = json!({
        "name": body.name,
        "material": body.material,
        key: mesh,
        "body_force": body.body_force,
        "displacement": body.displacements.iter().map(displacement).collect::<Vec<_>>(),
        "traction": body.tractions.iter().map(traction).collect::<Vec<_>>(),
    });
    if !body.regions.is_empty() {
        settings["region"] = body.regions.iter().map(region).collect();
    }
    settings
}

fn region(region: &MaterialRegion) -> Json {
    match &region.cells {
        CellSelection::Box(part) => json!({ "material": region.material, "box": limits(*part) }),
        CellSelection::Group(group) => json!({ "material": region.material, "group": group }),
    }
}

fn contact(contact: &Contact) -> Json {
    let gap = if contact.geometric { json!("geometric") } else { value(&contact.gap) };
    let mut object = Map::new();
    object.insert("surfaces".to_owned(), json!(contact.surfaces));
    object.insert("gap".to_owned(), gap);
    if let Some(normal) = contact.normal {
        object.insert("normal".to_owned(), json!(normal));
    }
    Json::Object(object)
}

fn mesh(source: &MeshSource) -> (&'static str, Json) {
    match source {
        MeshSource::Block { origin, size, cells } => {
            ("generator", json!({ "kind": "block", "origin": origin, "size": size, "cells": cells }))
        }
        MeshSource::Ring { centre, radii, angles, cells } => {
            let ring =
                json!({ "kind": "ring", "centre": centre, "radii": radii, "angles": angles, "cells": cells });
            ("generator", ring)
        }
        MeshSource::HalfDisc { pole, radius, facing, half_width, cells } => {
            let facing = super::read_body::facing_name(*facing);
            let disc = json!({
                "kind": "half_disc", "pole": pole, "radius": radius, "facing": facing, "half_width": half_width,
                "cells": cells
            });
            ("generator", disc)
        }
        MeshSource::File { file, region, merge, duplicate_interface } => {
            let mut object = Map::new();
            object.insert("file".to_owned(), json!(file));
            if let Some(region) = region {
                object.insert("region".to_owned(), json!(region));
            }
            object.insert("merge".to_owned(), json!(merge));
            object.insert("duplicate_interface".to_owned(), json!(duplicate_interface));
            ("mesh", Json::Object(object))
        }
    }
}

fn limits(part: Part) -> Map<String, Json> {
    let limits = [("x", part.x), ("y", part.y)].into_iter();
    limits.filter_map(|(key, limits)| limits.map(|l| (key.to_owned(), json!(l)))).collect()
}

fn edges(on: &str, part: Part) -> Map<String, Json> {
    let mut object = Map::new();
    object.insert("on".to_owned(), json!(on));
    let limits = limits(part);
    if !limits.is_empty() {
        object.insert("part".to_owned(), Json::Object(limits));
    }
    object
}

fn displacement(given: &Displacement) -> Json {
    let mut object = edges(&given.on, given.part);
    match &given.imposition {
        Imposition::Components(components) => {
            for (key, component) in ["ux", "uy"].into_iter().zip(components) {
                if let Some(component) = component {
                    object.insert(key.to_owned(), value(component));
                }
            }
        }
        Imposition::Normal(normal) => {
            object.insert("normal".to_owned(), value(normal));
        }
        Imposition::Fixed => {
            object.insert("fixed".to_owned(), json!(true));
        }
    }
    Json::Object(object)
}

fn traction(given: &Traction) -> Json {
    let mut object = edges(&given.on, given.part);
    match &given.load {
        Load::Vector(vector) => object.insert("vector".to_owned(), json!(vector.each_ref().map(value))),
        Load::Pressure(pressure) => object.insert("pressure".to_owned(), value(pressure)),
    };
    Json::Object(object)
}
