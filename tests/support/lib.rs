//! Reference problems with trusted answers.
