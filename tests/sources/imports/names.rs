//! From paths in the code to the files that define what they name.
//!
//! It follows `use` lines, re-exports and globs through the modules of the crate, and reads what stands in macros and
//! attributes as the paths that it looks like. It knows no types: a method is found where it is called by its path, and
//! not behind a dot. A file names that of another all the same, or it could not hold what it calls.

use crate::graph::Graph;
use crate::tree::{Id, Leaf, Tree, attributes, is_test_only, leaves, name_of};
use proc_macro2::{TokenStream, TokenTree};
use syn::visit::{self, Visit};
use syn::{Attribute, ItemUse, Macro, Path, Visibility};

/// Longest chain of re-exports that is followed; a longer one is a circle of them.
const MOST_STEPS: usize = 32;

/// What a path leads to.
#[derive(Clone, Copy)]
enum Named<'a> {
    /// A module of the crate.
    Module(&'a Target<'a>, Id),
    /// Something that a file of the crate defines.
    Item(&'a str),
}

/// A target, and the library of its package where that is another one.
#[derive(Clone, Copy)]
pub struct Target<'a> {
    /// The target's modules.
    pub tree: &'a Tree,
    /// The library by its name in paths.
    pub library: Option<(&'a str, &'a Target<'a>)>,
}

impl<'a> Target<'a> {
    /// The edges between the files that the target's own code makes.
    pub fn graph(&'a self) -> Graph {
        let mut graph = Graph::default();
        for (id, module) in self.tree.modules.iter().enumerate() {
            let mut reader = Reader { target: self, id, file: &module.file, graph: &mut graph };
            module.items.iter().for_each(|item| reader.visit_item(item));
        }
        graph
    }

    /// What `path` leads to from within the module `from`; none where that is no thing of the package.
    fn find(&'a self, from: Id, path: &[String], steps: usize) -> Option<Named<'a>> {
        let (first, mut rest) = path.split_first()?;
        let mut here = match first.as_str() {
            "crate" => Named::Module(self, 0),
            "self" => Named::Module(self, from),
            "super" => Named::Module(self, self.tree.modules[from].parent?),
            name => match self.name(from, name, rest.is_empty(), steps) {
                Some(found) => found,
                None => match self.library {
                    Some((library, target)) if library == name => Named::Module(target, 0),
                    _ => return None,
                },
            },
        };
        while let (Named::Module(target, id), Some((next, after))) = (here, rest.split_first()) {
            here = match next.as_str() {
                "self" => here,
                "super" => Named::Module(target, target.tree.modules[id].parent?),
                name => target.name(id, name, after.is_empty(), steps)?,
            };
            rest = after;
        }
        // What follows the name of an item is its own: a variant, an associated function.
        Some(here)
    }

    /// What `name` is in the module `id`. A module and a function may go by one name; only the last of a path is a
    /// function.
    fn name(&'a self, id: Id, name: &str, is_last: bool, steps: usize) -> Option<Named<'a>> {
        let steps = steps.checked_sub(1)?;
        let module = &self.tree.modules[id];
        let item = module.defined.contains(name).then_some(Named::Item(module.file.as_str()));
        let child = || module.children.get(name).map(|&child| Named::Module(self, child));
        let brought = || {
            // `use name::x` within a crate that has a `name` of its own would be found again and again.
            let path = module.uses.get(name).filter(|path| path[..] != [name.to_owned()])?;
            self.find(id, path, steps)
        };
        let globbed = || {
            module.globs.iter().find_map(|path| match self.find(id, path, steps)? {
                Named::Module(target, id) => target.name(id, name, is_last, steps),
                Named::Item(_) => None,
            })
        };
        let ordinary = if is_last { item.or_else(child) } else { child().or(item) };
        ordinary.or_else(brought).or_else(globbed)
    }

    /// Whether the file `file` belongs to the module `above` or one within it.
    fn holds(&self, above: Id, file: &str) -> bool {
        let modules = &self.tree.modules;
        let up = |id: &Id| modules[*id].parent;
        let of_file = (0..modules.len()).filter(|&id| modules[id].file == file);
        of_file.into_iter().any(|id| std::iter::successors(Some(id), up).any(|id| id == above))
    }
}

/// Goes through the code of one module and notes what it names.
struct Reader<'a, 'g> {
    target: &'a Target<'a>,
    id: Id,
    file: &'a str,
    graph: &'g mut Graph,
}

impl Reader<'_, '_> {
    fn note(&mut self, path: &[String]) {
        if let Some(Named::Item(file)) = self.target.find(self.id, path, MOST_STEPS) {
            self.graph.add(self.file, file, &path.join("::"));
        }
    }

    /// Reads tokens that no one has parsed: every `a::b::c` in them is a path, unless it stands behind a dot.
    fn read_tokens(&mut self, tokens: TokenStream) {
        let (mut path, mut colons, mut is_behind_dot) = (Vec::new(), 0, false);
        for token in tokens {
            match token {
                TokenTree::Ident(ident) => {
                    if colons != 2 {
                        self.note(&std::mem::take(&mut path));
                    }
                    if !is_behind_dot {
                        path.push(name_of(&ident));
                    }
                    (colons, is_behind_dot) = (0, false);
                }
                TokenTree::Punct(punct) if punct.as_char() == ':' && !path.is_empty() => {
                    colons += 1;
                }
                TokenTree::Punct(punct) => {
                    self.note(&std::mem::take(&mut path));
                    (colons, is_behind_dot) = (0, punct.as_char() == '.');
                }
                TokenTree::Group(group) => {
                    self.note(&std::mem::take(&mut path));
                    (colons, is_behind_dot) = (0, false);
                    self.read_tokens(group.stream());
                }
                TokenTree::Literal(literal) => {
                    self.note(&std::mem::take(&mut path));
                    (colons, is_behind_dot) = (0, false);
                    self.read_literal(&literal.to_string());
                }
            }
        }
        self.note(&path);
    }

    /// Attributes name functions and types in quotes: `#[serde(default = "Limits::none")]`.
    fn read_literal(&mut self, literal: &str) {
        let quoted = literal.strip_prefix('"').and_then(|rest| rest.strip_suffix('"'));
        if let Some(path) = quoted.and_then(|text| syn::parse_str::<Path>(text).ok()) {
            self.visit_path(&path);
        }
    }
}

impl<'ast> Visit<'ast> for Reader<'_, '_> {
    fn visit_item(&mut self, item: &'ast syn::Item) {
        if !attributes(item).iter().any(is_test_only) {
            visit::visit_item(self, item);
        }
    }

    fn visit_impl_item(&mut self, item: &'ast syn::ImplItem) {
        let attributes: &[Attribute] = match item {
            syn::ImplItem::Const(item) => &item.attrs,
            syn::ImplItem::Fn(item) => &item.attrs,
            syn::ImplItem::Type(item) => &item.attrs,
            syn::ImplItem::Macro(item) => &item.attrs,
            _ => &[],
        };
        if !attributes.iter().any(is_test_only) {
            visit::visit_impl_item(self, item);
        }
    }

    fn visit_field(&mut self, field: &'ast syn::Field) {
        if !field.attrs.iter().any(is_test_only) {
            visit::visit_field(self, field);
        }
    }

    fn visit_local(&mut self, local: &'ast syn::Local) {
        if !local.attrs.iter().any(is_test_only) {
            visit::visit_local(self, local);
        }
    }

    fn visit_path(&mut self, path: &'ast Path) {
        if path.leading_colon.is_none() {
            let names: Vec<String> =
                path.segments.iter().map(|part| name_of(&part.ident)).collect();
            self.note(&names);
        }
        visit::visit_path(self, path);
    }

    fn visit_item_use(&mut self, brought: &'ast ItemUse) {
        let is_shown = !matches!(brought.vis, Visibility::Inherited);
        for Leaf { path, .. } in leaves(&brought.tree) {
            let Some(Named::Item(file)) = self.target.find(self.id, &path, MOST_STEPS) else {
                continue;
            };
            // A parent that shows what its modules define does not name it: whoever uses it does.
            if !is_shown || !self.target.holds(self.id, file) {
                self.graph.add(self.file, file, &path.join("::"));
            }
        }
    }

    fn visit_visibility(&mut self, _: &'ast Visibility) {}

    fn visit_macro(&mut self, called: &'ast Macro) {
        if let Some(name) = called.path.get_ident() {
            if let Some(file) = self.target.tree.macros.get(&name_of(name)) {
                self.graph.add(self.file, file, &format!("{name}!"));
            }
        } else {
            self.visit_path(&called.path);
        }
        self.read_tokens(called.tokens.clone());
    }

    fn visit_attribute(&mut self, attribute: &'ast Attribute) {
        if attribute.path().is_ident("doc") {
            return;
        }
        if let syn::Meta::List(list) = &attribute.meta {
            self.read_tokens(list.tokens.clone());
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::package::Package;

    /// A package of made-up files with a library and, where there is one, a program.
    fn package(files: &[(&str, &str)]) -> Package {
        let file = |(path, text): &(&str, &str)| (path.to_string(), text.to_string());
        let program = files.iter().any(|(path, _)| *path == "main.rs").then_some("main.rs");
        let files = files.iter().map(file).collect();
        Package::new("made-up", files, Some("lib.rs"), program.as_slice())
    }

    /// Who names whom, without what.
    fn imports(files: &[(&str, &str)]) -> Vec<String> {
        let package = package(files);
        package.graph.edges().map(|(from, to, _)| format!("{from} -> {to}")).collect()
    }

    #[test]
    fn a_planted_circle_is_found() {
        let files = [
            ("lib.rs", "mod a; mod b; pub use a::A;"),
            ("a.rs", "use crate::b::B; pub struct A(B);"),
            ("b.rs", "pub struct B; impl B { pub fn a(self) -> crate::A { crate::A(self) } }"),
        ];
        assert_eq!(package(&files).graph.circles(), [["a.rs", "b.rs"]]);
    }

    #[test]
    fn a_child_that_uses_its_parent_and_is_used_by_it_is_a_circle() {
        let child = ("p/child.rs", "use super::Shared; pub fn f(_: Shared) {}");
        let uses = ("p/mod.rs", "mod child; pub struct Shared; fn g() { child::f(Shared) }");
        let shows = ("p/mod.rs", "mod child; pub use child::f; pub struct Shared;");
        assert_eq!(
            imports(&[("lib.rs", "mod p;"), uses, child]),
            ["p/child.rs -> p/mod.rs", "p/mod.rs -> p/child.rs"]
        );
        assert_eq!(imports(&[("lib.rs", "mod p;"), shows, child]), ["p/child.rs -> p/mod.rs"]);
    }

    #[test]
    fn names_are_followed_through_modules_aliases_globs_and_re_exports() {
        let tree = [
            ("lib.rs", "mod low; mod mid; mod top; mod inline { pub use crate::mid::*; }"),
            ("low.rs", "pub struct Low; pub mod deep { pub const DEEP: u8 = 0; } pub enum E { V }"),
            ("mid.rs", "pub use crate::low::{self as under, Low as Renamed};"),
        ];
        for (text, is_found) in [
            ("use crate::inline::Renamed;", true),
            ("fn f() -> u8 { crate::mid::under::deep::DEEP }", true),
            ("fn f() { use super::low; let _ = low::E::V; }", true),
            ("fn f() { println!(\"{}\", crate::low::deep::DEEP) }", true),
            (
                "#[derive(Deserialize)] struct S { #[serde(default = \"crate::low::Low\")] s: u8 }",
                true,
            ),
            ("use crate::mid::*; impl Drop for Renamed {}", true),
            ("use crate::low;", false),
            ("use std::low::Low; fn f(low: u8) { low.deep.DEEP }", false),
            ("/// See [`crate::low::Low`].\nstruct S;", false),
            ("#[cfg(test)] mod tests { use crate::low::Low; }", false),
            ("struct S; impl S { #[cfg(all(test, unix))] fn f(_: crate::low::Low) {} }", false),
            ("#[cfg(not(test))] use crate::low::Low;", true),
        ] {
            let files = [&tree[..], &[("top.rs", text)]].concat();
            let found = imports(&files).contains(&"top.rs -> low.rs".to_owned());
            assert_eq!(found, is_found, "{text}");
        }
    }

    #[test]
    fn a_program_names_the_library_and_macros_are_where_they_are_defined() {
        let files = [
            ("lib.rs", "#[macro_use] mod said; mod used; pub use used::f;"),
            ("said.rs", "macro_rules! say { () => { $crate::f() } }"),
            ("used.rs", "pub fn f() {} fn g() { say!() }"),
            ("main.rs", "mod arguments; fn main() { made_up::f() }"),
            ("arguments.rs", "use made_up::f as run;"),
        ];
        let expected = ["arguments.rs -> used.rs", "main.rs -> used.rs", "said.rs -> used.rs"];
        assert_eq!(imports(&files)[..3], expected);
        assert_eq!(package(&files).graph.circles(), [["said.rs", "used.rs"]]);
    }

    #[test]
    fn files_for_tests_alone_are_no_production() {
        let files = [
            ("lib.rs", "mod a; #[cfg(test)] mod tests;"),
            ("a.rs", "pub struct A;"),
            ("tests/mod.rs", "mod more; use crate::a::A;"),
            ("tests/more.rs", "use crate::a::A;"),
        ];
        let package = package(&files);
        assert_eq!(package.graph.len(), 0);
        assert_eq!(package.production.iter().collect::<Vec<_>>(), ["a.rs", "lib.rs"]);
    }

    #[test]
    #[should_panic(expected = "no module declares [\"lost.rs\"]")]
    fn a_file_that_no_module_declares_is_reported() {
        package(&[("lib.rs", ""), ("lost.rs", "")]);
    }
}
