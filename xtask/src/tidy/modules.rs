//! The modules of each crate: neighbours take from each other in one direction only.
//!
//! A module may use its parent's items and its children's. Two neighbours, children of one parent, with all that is below
//! them, must not use each other, directly or in a ring. A crate that must not know about meshes takes from `fem_core` only what
//! [`ALGEBRA`] lists. Nothing but [`SPACE`] asks for the number of dimensions, and nothing has a `where` clause.

use super::finding::Finding;
use std::collections::{BTreeMap, BTreeSet};
use syn::visit::{self, Visit};
use syn::{Attribute, BinOp, Expr, ExprBinary, ExprMatch, Item, ItemMod, ItemUse, Lit, UseTree, WhereClause};

/// The path of a module below the root of its crate.
type Module = Vec<String>;

/// Which neighbour takes from which, below one parent: and the file that shows it, with the line.
type Arrows = BTreeMap<(String, String), (String, usize)>;

/// The crates that see contact as algebra alone, and the items of `fem_core` that they may use.
const ALGEBRA: [(&str, &[&str]); 1] =
    [("nndd", &["contact_system", "condensation", "dense", "each_body", "norm", "try_each_body"])];

/// The files that may ask for the number of dimensions: all others loop over axes, corners and components.
const SPACE: &str = "crates/fem-core/src/space";

/// The constants of a space that are a number of dimensions.
const DIMENSIONS: [&str; 2] = ["DIM", "COMPONENTS"];

/// Finds the rings of neighbours in the sources of the crates, what takes from meshes without need, and what asks for the dimension.
///
/// * `sources`: names from the top folder, and texts; only files in `crates/*/src` count.
pub(super) fn findings(sources: &[(String, String)]) -> Vec<Finding> {
    let mut crates: BTreeMap<&str, Vec<(Module, &str, &str)>> = BTreeMap::new();
    for (file, text) in sources {
        if let Some((name, module)) = place(file) {
            crates.entry(name).or_default().push((module, file, text));
        }
    }
    crates
        .iter()
        .flat_map(|(name, files)| {
            of_crate(files).into_iter().chain(beyond_algebra(name, files)).chain(beside_space(files))
        })
        .collect()
}

/// Finds comparisons of the number of dimensions with a number, matches on it, and `where` clauses.
fn beside_space(files: &[(Module, &str, &str)]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (_, file, text) in files {
        let Ok(tree) = syn::parse_file(text) else { continue };
        let mut asked = Asked::default();
        asked.visit_file(&tree);
        let line = |word: &str| text.lines().position(|l| l.contains(word)).map_or(1, |k| k + 1);
        if asked.dimension && !file.starts_with(SPACE) {
            let what = format!("found a question for the number of dimensions, expected it in {SPACE} alone");
            findings.push(Finding::new(file, line("::DIM").max(line("::COMPONENTS")), what));
        }
        if asked.condition {
            let what = "found a `where` clause, expected bounds of an associated type".to_owned();
            findings.push(Finding::new(file, line("where "), what));
        }
    }
    findings
}

/// Whether a file asks for the number of dimensions, or has a `where` clause; its tests are left out.
#[derive(Default)]
struct Asked {
    dimension: bool,
    condition: bool,
}

/// Tells whether an expression is made of the number of dimensions: `S::DIM`, `S::DIM - 1`.
fn is_dimension(expression: &Expr) -> bool {
    match expression {
        Expr::Path(path) => {
            path.path.segments.last().is_some_and(|s| DIMENSIONS.iter().any(|known| s.ident == known))
        }
        Expr::Binary(sum) => is_dimension(&sum.left) || is_dimension(&sum.right),
        Expr::Paren(inner) => is_dimension(&inner.expr),
        _ => false,
    }
}

fn is_number(expression: &Expr) -> bool {
    matches!(expression, Expr::Lit(literal) if matches!(literal.lit, Lit::Int(_)))
}

impl<'ast> Visit<'ast> for Asked {
    fn visit_expr_binary(&mut self, pair: &'ast ExprBinary) {
        let compares = matches!(
            pair.op,
            BinOp::Eq(_) | BinOp::Ne(_) | BinOp::Lt(_) | BinOp::Le(_) | BinOp::Gt(_) | BinOp::Ge(_)
        );
        let asks = |a: &Expr, b: &Expr| is_dimension(a) && is_number(b);
        self.dimension |= compares && (asks(&pair.left, &pair.right) || asks(&pair.right, &pair.left));
        visit::visit_expr_binary(self, pair);
    }

    fn visit_expr_match(&mut self, choice: &'ast ExprMatch) {
        self.dimension |= is_dimension(&choice.expr);
        visit::visit_expr_match(self, choice);
    }

    fn visit_where_clause(&mut self, _: &'ast WhereClause) {
        self.condition = true;
    }

    fn visit_item_mod(&mut self, item: &'ast ItemMod) {
        if !is_test(&item.attrs) {
            visit::visit_item_mod(self, item);
        }
    }
}

/// Finds the paths into `fem_core` that a crate of [`ALGEBRA`] must not take.
fn beyond_algebra(name: &str, files: &[(Module, &str, &str)]) -> Vec<Finding> {
    let Some((_, allowed)) = ALGEBRA.iter().find(|(known, _)| *known == name) else { return Vec::new() };
    let mut findings = Vec::new();
    for (_, file, text) in files {
        let mut paths = Paths::default();
        // A file that is no Rust is found with the rings.
        let Ok(tree) = syn::parse_file(text) else { continue };
        paths.visit_file(&tree);
        for path in paths.found.iter().filter(|path| path[0] == "fem_core") {
            let Some(item) = path.get(1).filter(|item| !allowed.contains(&item.as_str())) else { continue };
            let line = text.lines().position(|l| l.contains(item.as_str())).map_or(1, |k| k + 1);
            findings.push(Finding::new(
                file,
                line,
                format!("found `fem_core::{item}` in `{name}`, expected one of {}", allowed.join(", ")),
            ));
        }
    }
    findings
}

/// Returns the crate and the module of a source file; `None` for tests.
fn place(file: &str) -> Option<(&str, Module)> {
    let (name, inside) = file.strip_prefix("crates/")?.split_once("/src/")?;
    let path = inside.strip_suffix(".rs")?;
    let path = path.strip_suffix("/mod").unwrap_or(path);
    let module: Module = match path {
        "lib" | "main" => Vec::new(),
        _ => path.split('/').map(str::to_owned).collect(),
    };
    (!module.iter().any(|part| part == "tests")).then_some((name, module))
}

fn of_crate(files: &[(Module, &str, &str)]) -> Vec<Finding> {
    let modules: BTreeSet<&Module> = files.iter().map(|(module, ..)| module).collect();
    let mut findings = Vec::new();
    let mut parents: BTreeMap<Module, Arrows> = BTreeMap::new();
    for (module, file, text) in files {
        let tree = match syn::parse_file(text) {
            Ok(tree) => tree,
            Err(error) => {
                findings.push(Finding::new(file, 1, format!("found {error}, expected Rust")));
                continue;
            }
        };
        let mut paths = Paths::default();
        paths.visit_file(&tree);
        for path in paths.found {
            let Some(target) = resolve(&path, module, &modules) else { continue };
            let common = module.iter().zip(&target).take_while(|(a, b)| a == b).count();
            if let (Some(from), Some(to)) = (module.get(common), target.get(common)) {
                let line = text.lines().position(|l| l.contains(&format!("{to}::"))).map_or(1, |k| k + 1);
                let arrows = parents.entry(module[..common].to_vec()).or_default();
                arrows.entry((from.clone(), to.clone())).or_insert(((*file).to_owned(), line));
            }
        }
    }
    for arrows in parents.values() {
        for ((from, to), (file, line)) in arrows.iter().filter(|((from, to), _)| reaches(arrows, to, from)) {
            findings.push(Finding::new(
                file,
                *line,
                format!("found `{from}` taking from its neighbour `{to}`, which takes from `{from}` in turn, expected one direction"),
            ));
        }
    }
    findings
}

/// Tells whether there is a way along the arrows.
fn reaches(arrows: &Arrows, from: &str, to: &str) -> bool {
    let (mut seen, mut open) = (BTreeSet::new(), vec![from]);
    while let Some(here) = open.pop() {
        if here == to {
            return true;
        }
        if seen.insert(here) {
            open.extend(arrows.keys().filter(|(a, _)| a == here).map(|(_, b)| b.as_str()));
        }
    }
    false
}

/// Finds the module that a path leads to: as far as its words are modules.
fn resolve(path: &[String], here: &Module, modules: &BTreeSet<&Module>) -> Option<Module> {
    let mut words = path.iter().map(String::as_str).peekable();
    let mut target = match words.next()? {
        "crate" => Vec::new(),
        "self" => here.clone(),
        "super" => here[..here.len().checked_sub(1)?].to_vec(),
        _ => return None,
    };
    while words.next_if_eq(&"super").is_some() {
        target.pop()?;
    }
    for word in words {
        target.push(word.to_owned());
        if !modules.contains(&target) {
            target.pop();
            break;
        }
    }
    Some(target)
}

/// The paths in a file that begin with `crate`, `self` or `super`; paths in its tests are left out.
#[derive(Default)]
struct Paths {
    found: Vec<Vec<String>>,
}

impl Paths {
    fn expand(&mut self, before: &[String], tree: &UseTree) {
        let with = |name: String| [before, &[name]].concat();
        match tree {
            UseTree::Path(path) => self.expand(&with(path.ident.to_string()), &path.tree),
            UseTree::Name(name) => self.found.push(with(name.ident.to_string())),
            UseTree::Rename(name) => self.found.push(with(name.ident.to_string())),
            UseTree::Glob(_) => self.found.push(before.to_vec()),
            UseTree::Group(group) => group.items.iter().for_each(|item| self.expand(before, item)),
        }
    }
}

fn is_test(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|a| {
        a.path().is_ident("cfg") && a.parse_args::<syn::Path>().is_ok_and(|path| path.is_ident("test"))
    })
}

impl<'ast> Visit<'ast> for Paths {
    fn visit_item(&mut self, item: &'ast Item) {
        let attributes: &[Attribute] = match item {
            Item::Fn(item) => &item.attrs,
            Item::Impl(item) => &item.attrs,
            Item::Use(item) => &item.attrs,
            _ => &[],
        };
        if !is_test(attributes) {
            visit::visit_item(self, item);
        }
    }

    fn visit_item_mod(&mut self, item: &'ast ItemMod) {
        if !is_test(&item.attrs) {
            visit::visit_item_mod(self, item);
        }
    }

    fn visit_item_use(&mut self, item: &'ast ItemUse) {
        self.expand(&[], &item.tree);
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        self.found.push(path.segments.iter().map(|s| s.ident.to_string()).collect());
        visit::visit_path(self, path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(files: &[(&str, &str)]) -> Vec<String> {
        let sources: Vec<_> =
            files.iter().map(|(f, t)| (format!("crates/c/src/{f}.rs"), (*t).to_owned())).collect();
        findings(&sources).into_iter().map(|f| format!("{}:{}: {}", f.file, f.line, f.what)).collect()
    }

    #[test]
    fn parents_and_children_may_use_each_other() {
        let files = [
            ("lib", "mod a; mod b; pub use a::A;"),
            ("a", "mod x; use x::X; pub struct A; use crate::b::B;"),
            ("a/x", "use super::A; pub struct X;"),
            (
                "b",
                "pub struct B; #[cfg(test)] mod tests { use crate::a::A; } #[cfg(test)] fn f(a: crate::a::A) {}",
            ),
            ("b/tests", "use crate::a::A;"),
        ];
        assert_eq!(found(&files), [""; 0]);
    }

    #[test]
    fn a_crate_of_algebra_takes_nothing_from_meshes() {
        let text = "use fem_core::{norm, mesh::Mesh as M};\nuse fem_core::body::*;\n#[cfg(test)] mod tests { use fem_core::body; }";
        let of = |name: &str| findings(&[(format!("crates/{name}/src/lib.rs"), text.to_owned())]);
        let found: Vec<String> = of("nndd").into_iter().map(|f| format!("{}: {}", f.line, f.what)).collect();
        let expected = "expected one of contact_system, condensation, dense, each_body, norm, try_each_body";
        let line = |k: usize, item: &str| format!("{k}: found `fem_core::{item}` in `nndd`, {expected}");
        assert_eq!(found, [line(1, "mesh"), line(2, "body")]);
        assert!(of("cre-estimator").is_empty());
    }

    #[test]
    fn the_number_of_dimensions_is_asked_for_in_one_place() {
        let asked = |file: &str, text: &str| {
            let sources = [(format!("crates/fem-core/src/{file}.rs"), text.to_owned())];
            findings(&sources).into_iter().map(|f| f.what).collect::<Vec<_>>()
        };
        for text in [
            "fn f<S>() { if S::DIM == 3 {} }",
            "fn f<S>() { g(2 < S::COMPONENTS - 1) }",
            "fn f<S>() { match S::DIM { 2 => (), _ => () } }",
        ] {
            assert!(asked("body", text)[0].starts_with("found a question"), "{text}");
            assert!(asked("space/plane", text).is_empty());
        }
        assert!(asked("body", "fn f<S>(k: usize) { for j in 1..S::DIM {} if k < S::DIM {} }").is_empty());
        assert!(asked("body", "fn f<S>() where S: Copy {}")[0].starts_with("found a `where` clause"));
    }

    #[test]
    fn neighbours_that_use_each_other_are_found() {
        let files = [
            ("lib", "mod a; mod b; mod c;"),
            ("a", "pub mod x;"),
            ("a/x", "\nuse crate::{b::{self, B as D}, c};"),
            ("b", "fn f() { crate::c::g() }"),
            ("c", "pub fn g() -> super::a::x::X {}"),
        ];
        let found = found(&files);
        assert_eq!(found.len(), 4, "{found:?}");
        assert!(
            found[0].starts_with("crates/c/src/a/x.rs:2: found `a` taking from its neighbour `b`"),
            "{found:?}"
        );
    }

    #[test]
    fn what_is_no_rust_is_said() {
        assert!(found(&[("a", "fn f( {")])[0].contains("expected Rust"));
        assert!(findings(&[("xtask/src/a.rs".to_owned(), "fn f( {".to_owned())]).is_empty());
    }
}
