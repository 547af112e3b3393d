//! The modules of one target as its files declare them, from the root on, without what is compiled for tests alone.

use std::collections::{BTreeMap, BTreeSet};
use syn::parse::Parser;
use syn::punctuated::Punctuated;
use syn::visit::Visit;
use syn::{Attribute, Item, ItemUse, Meta, Token, UseTree};

/// The files of a package: their paths below its `src`, and what is in them.
pub type Files = BTreeMap<String, String>;

/// The place of a module in [`Tree::modules`].
pub type Id = usize;

/// A module: a file, or a part of one in braces.
#[derive(Default)]
pub struct Module {
    /// The file that it is in.
    pub file: String,
    /// The module that declares it; none for the root.
    pub parent: Option<Id>,
    /// The modules that it declares.
    pub children: BTreeMap<String, Id>,
    /// The names that it defines.
    pub defined: BTreeSet<String>,
    /// What its `use` lines bring in: the name here, and the path that it stands for.
    pub uses: BTreeMap<String, Vec<String>>,
    /// The paths of its `use ...::*`.
    pub globs: Vec<Vec<String>>,
    /// All that is in it.
    pub items: Vec<Item>,
}

/// All modules of one target. The root is the first.
#[derive(Default)]
pub struct Tree {
    /// In the order in which they are declared.
    pub modules: Vec<Module>,
    /// Where each macro of the target is defined.
    pub macros: BTreeMap<String, String>,
    /// The files that are compiled for tests alone.
    pub tests: BTreeSet<String>,
}

impl Tree {
    /// Reads the target whose root is the file `root`.
    ///
    /// # Panics
    /// Where a file is missing or is no Rust: then the compiler has more to say.
    pub fn read(files: &Files, root: &str) -> Self {
        let mut tree = Self::default();
        tree.read_file(files, root, &folder(root), None, false);
        tree
    }

    /// The files of production code.
    pub fn production(&self) -> BTreeSet<&str> {
        self.modules.iter().map(|module| module.file.as_str()).collect()
    }

    /// Reads the module that is the file `file`, whose modules' files are in `inside`.
    fn read_file(
        &mut self,
        files: &Files,
        file: &str,
        inside: &str,
        parent: Option<Id>,
        is_test: bool,
    ) -> Id {
        let text = files.get(file).unwrap_or_else(|| panic!("there is no {file}"));
        let parsed = syn::parse_file(text).unwrap_or_else(|error| panic!("{file}: {error}"));
        self.read_module(files, file, inside, parent, parsed.items, is_test)
    }

    fn read_module(
        &mut self,
        files: &Files,
        file: &str,
        inside: &str,
        parent: Option<Id>,
        items: Vec<Item>,
        is_test: bool,
    ) -> Id {
        let id = self.modules.len();
        let module = Module { file: file.to_owned(), parent, ..Module::default() };
        if is_test {
            // Its modules are looked for all the same: their files are tests too.
            self.tests.insert(file.to_owned());
        } else {
            self.modules.push(module);
        }
        for item in items {
            let is_test = is_test || attributes(&item).iter().any(is_test_only);
            if let Item::Mod(declared) = item {
                let name = name_of(&declared.ident);
                let path = format!("{inside}{name}");
                let child = if let Some((_, items)) = declared.content {
                    self.read_module(files, file, &format!("{path}/"), Some(id), items, is_test)
                } else {
                    let flat = format!("{path}.rs");
                    let found =
                        if files.contains_key(&flat) { flat } else { format!("{path}/mod.rs") };
                    self.read_file(files, &found, &format!("{path}/"), Some(id), is_test)
                };
                if !is_test {
                    self.modules[id].children.insert(name, child);
                }
            } else if !is_test {
                self.define(id, item);
            }
        }
        id
    }

    /// Notes what `item` defines or brings in.
    fn define(&mut self, id: Id, item: Item) {
        let module = &mut self.modules[id];
        match &item {
            Item::Use(brought) => bring_in(module, brought),
            Item::Macro(defined) => {
                if let Some(name) = &defined.ident {
                    self.macros.insert(name_of(name), module.file.clone());
                }
            }
            _ => {
                module.defined.extend(defined_name(&item));
                // What a function brings in for itself is taken for the module's.
                Within(module).visit_item(&item);
            }
        }
        module.items.push(item);
    }
}

/// Looks for the `use` lines within functions.
struct Within<'a>(&'a mut Module);

impl<'ast> Visit<'ast> for Within<'_> {
    fn visit_item_use(&mut self, brought: &'ast ItemUse) {
        bring_in(self.0, brought);
    }
}

/// Adds what a `use` brings in to the names of `module`.
fn bring_in(module: &mut Module, brought: &ItemUse) {
    for leaf in leaves(&brought.tree) {
        match leaf.name {
            Some(name) => drop(module.uses.insert(name, leaf.path)),
            None => module.globs.push(leaf.path),
        }
    }
}

/// One path of a `use`.
pub struct Leaf {
    /// The whole of it.
    pub path: Vec<String>,
    /// What it is called here; none for `*`.
    pub name: Option<String>,
}

/// The paths of a `use`, one by one.
pub fn leaves(tree: &UseTree) -> Vec<Leaf> {
    let mut leaves = Vec::new();
    collect(tree, &mut Vec::new(), &mut leaves);
    leaves
}

fn collect(tree: &UseTree, before: &mut Vec<String>, leaves: &mut Vec<Leaf>) {
    match tree {
        UseTree::Path(path) => {
            before.push(name_of(&path.ident));
            collect(&path.tree, before, leaves);
            before.pop();
        }
        UseTree::Group(group) => group.items.iter().for_each(|tree| collect(tree, before, leaves)),
        UseTree::Glob(_) => leaves.push(Leaf { path: before.clone(), name: None }),
        UseTree::Name(named) => push(&named.ident, None, before, leaves),
        UseTree::Rename(named) => push(&named.ident, Some(&named.rename), before, leaves),
    }
}

fn push(
    named: &syn::Ident,
    renamed: Option<&syn::Ident>,
    before: &[String],
    leaves: &mut Vec<Leaf>,
) {
    let mut path = before.to_vec();
    // `use a::{self}` is `use a`.
    if named != "self" || path.is_empty() {
        path.push(name_of(named));
    }
    let name = renamed.map_or_else(|| path.last().cloned(), |name| Some(name_of(name)));
    leaves.push(Leaf { path, name });
}

/// The folder of the files that the root of a target declares.
fn folder(root: &str) -> String {
    root.rfind('/').map_or_else(String::new, |slash| root[..=slash].to_owned())
}

/// A name without the `r#` of one that is a keyword.
pub fn name_of(ident: &syn::Ident) -> String {
    let name = ident.to_string();
    name.strip_prefix("r#").map(str::to_owned).unwrap_or(name)
}

fn defined_name(item: &Item) -> Option<String> {
    let ident = match item {
        Item::Const(item) => &item.ident,
        Item::Enum(item) => &item.ident,
        Item::Fn(item) => &item.sig.ident,
        Item::Static(item) => &item.ident,
        Item::Struct(item) => &item.ident,
        Item::Trait(item) => &item.ident,
        Item::TraitAlias(item) => &item.ident,
        Item::Type(item) => &item.ident,
        Item::Union(item) => &item.ident,
        _ => return None,
    };
    Some(name_of(ident))
}

/// The attributes of an item.
pub fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(item) => &item.attrs,
        Item::Enum(item) => &item.attrs,
        Item::ExternCrate(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::ForeignMod(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        Item::Macro(item) => &item.attrs,
        Item::Mod(item) => &item.attrs,
        Item::Static(item) => &item.attrs,
        Item::Struct(item) => &item.attrs,
        Item::Trait(item) => &item.attrs,
        Item::TraitAlias(item) => &item.attrs,
        Item::Type(item) => &item.attrs,
        Item::Union(item) => &item.attrs,
        Item::Use(item) => &item.attrs,
        _ => &[],
    }
}

/// Whether an attribute says that what it stands at is compiled for tests alone: `cfg(test)`, or `cfg(all(test, ...))`.
pub fn is_test_only(attribute: &Attribute) -> bool {
    attribute.path().is_ident("cfg")
        && attribute.parse_args::<Meta>().is_ok_and(|condition| needs_test(&condition))
}

fn needs_test(condition: &Meta) -> bool {
    match condition {
        Meta::Path(path) => path.is_ident("test"),
        Meta::List(list) if list.path.is_ident("all") => {
            let parts = Punctuated::<Meta, Token![,]>::parse_terminated.parse2(list.tokens.clone());
            parts.is_ok_and(|parts| parts.iter().any(needs_test))
        }
        _ => false,
    }
}
