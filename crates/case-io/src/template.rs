//! Commented case files to start from, for `nndd new`.

/// The test problem of the paper: two blocks that lose contact, with the paper's settings.
pub const PAPER: &str = include_str!("template/paper.toml");

/// Two blocks under uniform pressure: constant stresses, which linear triangles represent exactly.
pub const PATCH: &str = include_str!("template/patch.toml");

/// Meshes refined until the certified error is below a target.
pub const ADAPTIVE: &str = include_str!("template/adaptive.toml");

/// Hertz' contact of two cylinders: curved sides and a gap that is measured on the meshes.
pub const HERTZ: &str = include_str!("template/hertz.toml");

/// A roller between a base and a plate, held by contact only.
pub const ASSEMBLY: &str = include_str!("template/assembly.toml");

/// Two bodies from a mesh file, with the names to replace.
pub const GMSH: &str = include_str!("template/gmsh.toml");

/// Two solids, one of them held by contact only.
pub const SOLID: &str = include_str!("template/solid.toml");

/// The templates by name.
pub const TEMPLATES: &[(&str, &str)] = &[
    ("paper", PAPER),
    ("patch", PATCH),
    ("hertz", HERTZ),
    ("adaptive", ADAPTIVE),
    ("assembly", ASSEMBLY),
    ("gmsh", GMSH),
    ("solid", SOLID),
];

/// Finds a template by its name.
pub fn find(name: &str) -> Option<&'static str> {
    TEMPLATES.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
}
