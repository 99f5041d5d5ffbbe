//! nndd
fn main(){}
