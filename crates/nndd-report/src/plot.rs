//! Figures of a run as SVG text: the problem, indicators against a swept value, the convergence history, the adaptive one, the deformed
//! bodies coloured by a field, and pressure and opening along the contact.
//!
//! Every function returns a whole SVG document. Numbers that cannot be drawn (not
//! finite, or not positive on a logarithmic axis) are left out; if nothing is left the figure says
//! `no data`. Colours are taken from Okabe and Ito and from the viridis map, which remain distinct to
//! colour-blind readers, and series differ by marker and dash as well.

mod adaptive;
mod axis;
mod bands;
mod cells;
mod colour;
mod contact;
mod convergence;
mod deformed;
mod labels;
mod legend;
mod lines;
mod look;
mod names;
mod obstacle;
mod outline;
mod path;
mod scale;
mod sheet;
mod sketch;
mod steps;
mod sweep;
#[cfg(test)]
mod tests;
mod views;

pub(crate) use adaptive::{Measure, adaptive};
pub(crate) use contact::contact;
pub(crate) use convergence::convergence;
pub(crate) use deformed::{Closing, deformed, magnified};
pub(crate) use labels::Labels;
pub(crate) use obstacle::{Motion, ObstaclePicture};
pub(crate) use path::path;
pub(crate) use scale::{BodyPicture, Field, Quantity, Scale};
pub(crate) use sketch::{Held, SketchBody, SketchEdge, SketchLoad, sketch};
pub(crate) use steps::{Along, Forces, steps};
pub(crate) use sweep::sweep;
pub(crate) use views::{Entry, OUTLINE, Panel, Views, of_body, of_edges, scale_colours, views};
