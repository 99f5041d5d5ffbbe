//! Tests that run across the crates: reference problems, the example cases, the binary as a process.
// All of this is test code: a failed unwrap is a failed test.
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

mod adaptive;
mod adversarial;
mod assemblies;
mod assemblies_nndd;
mod assembly_cases;
mod assembly_random;
mod bound;
mod bounds;
mod cattaneo;
mod certificate;
mod contact_force;
mod curved;
mod curved_non_matching;
mod curved_sides;
mod data;
mod effectivity;
mod elasticity;
mod facing;
mod friction;
mod friction_adaptive;
mod friction_bound;
mod friction_case;
mod friction_public;
mod friction_solve;
mod honesty;
mod iteration;
mod key_page;
mod limit;
mod load_steps;
mod mesh_files;
mod non_matching;
mod paper;
mod patch;
mod point_supports;
mod reactions;
mod recovered_pressure;
mod refusals;
mod resume;
mod rounded_punch;
mod sharpness;
mod solve;
mod step_case;
mod terms;
mod threads;
