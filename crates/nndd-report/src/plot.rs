//! Figures of a run as SVG text: the problem, indicators against a swept value, the convergence history, the adaptive one, the deformed
//! bodies coloured by error density, and pressure and opening along the contact.
//!
//! Every function returns a whole SVG document. Numbers that cannot be drawn (not
//! finite, or not positive on a logarithmic axis) are left out; if nothing is left the figure says
//! `no data`. Colours are those of Okabe and Ito and of the viridis map, which remain distinct to
//! colour-blind readers, and series differ by marker and dash as well.

mod adaptive;
mod axis;
mod cells;
mod colour;
mod contact;
mod convergence;
mod deformed;
mod legend;
mod lines;
mod look;
mod names;
mod obstacle;
mod outline;
mod sheet;
mod sketch;
mod sweep;
#[cfg(test)]
mod tests;

pub(crate) use adaptive::adaptive;
pub(crate) use contact::contact;
pub(crate) use convergence::convergence;
pub(crate) use deformed::{BodyPicture, Closing, deformed};
pub(crate) use obstacle::{Motion, ObstaclePicture};
pub(crate) use sketch::{Held, SketchBody, SketchEdge, SketchLoad, sketch};
pub(crate) use sweep::sweep;
