//! Guaranteed bounds of the error of a contact solution by the constitutive relation error
