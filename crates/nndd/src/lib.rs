//! The Neumann-Neumann domain decomposition of Choi, Gallimard and Sassi for frictionless unilateral contact
