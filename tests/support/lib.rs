//! Reference problems with trusted answers, one file each, and the few steps every test shares.
//!
//! Each file says where its reference values come from and of which kind they are: exact, from an
//! independent code, or an earlier value of this code.

pub mod assemblies;
pub mod blocks;
pub mod cattaneo;
pub mod columns;
pub mod cook;
pub mod corner;
pub mod distance;
pub mod effectivity;
pub mod finer;
pub mod formulation;
pub mod friction;
pub mod full_size;
pub mod goursat;
pub mod heavy;
pub mod hertz;
pub mod hertz_box;
pub mod interference;
pub mod kinked;
pub mod kirsch;
pub mod layers;
pub mod matrix;
pub mod mesh_files;
pub mod model;
pub mod overkill;
pub mod paper;
pub mod patch;
pub mod pin;
pub mod precise;
pub mod quadratic;
pub mod random;
pub mod random_assemblies;
pub mod random_solids;
pub mod receding;
pub mod rings;
pub mod rollers;
pub mod rounded_punch;
pub mod run;
pub mod shapes;
pub mod sharp;
pub mod signorini;
pub mod smooth;
pub mod solids;
pub mod stacks;
pub mod tresca;

pub use run::{certify, condense, displacements, iterates, prepare};
