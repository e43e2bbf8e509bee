//! Import graph of a crate: which of its modules name which others, and the circles in it.
//!
//! A module is a file. Module `a` depends on module `b` when `a` names something of `b`: in a `use`, in a path, or in the
//! arguments of a macro. A name that `b` re-exports counts as one of the module that defines it. Declarations (`mod b;`) and tests
//! do not count.

use petgraph::{algo::tarjan_scc, graph::DiGraph};
use proc_macro2::{TokenStream, TokenTree};
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::Path,
};
use syn::{
    Attribute, ItemMod, ItemUse, Macro, UseTree,
    visit::{self, Visit},
};

/// Path of a module below its crate; empty for the root.
pub type Module = Vec<String>;

/// The modules of a crate, each with the modules that it depends on.
pub type Imports = BTreeMap<Module, BTreeSet<Module>>;

/// Returns the imports of the crate whose root is `lib.rs` in this folder.
pub fn imports(src: &Path) -> Imports {
    let mut files = BTreeMap::new();
    collect(src, &[], &mut files);
    let exports: BTreeMap<Module, BTreeMap<String, Module>> =
        files.iter().map(|(module, file)| (module.clone(), exports(module, file))).collect();
    let known = Known { exports };
    let each = files.iter().map(|(module, file)| {
        let mut seen = Names {
            known: &known,
            at: module.clone(),
            file: module.clone(),
            found: BTreeSet::new(),
        };
        seen.visit_file(file);
        seen.found.remove(module);
        (module.clone(), seen.found)
    });
    each.collect()
}

/// Returns the groups of modules that depend on each other in a circle, the largest first.
pub fn circles(imports: &Imports) -> Vec<Vec<String>> {
    let mut graph = DiGraph::new();
    let nodes: BTreeMap<_, _> = imports.keys().map(|m| (m, graph.add_node(m))).collect();
    for (from, to) in imports {
        for to in to {
            graph.add_edge(nodes[from], nodes[to], ());
        }
    }
    let mut found: Vec<Vec<String>> = tarjan_scc(&graph)
        .into_iter()
        .filter(|circle| circle.len() > 1)
        .map(|circle| {
            let mut names: Vec<_> = circle.into_iter().map(|n| shown(graph[n])).collect();
            names.sort();
            names
        })
        .collect();
    found.sort_by_key(|circle| (std::cmp::Reverse(circle.len()), circle.clone()));
    found
}

/// Returns a module as a reader would write it.
pub fn shown(module: &Module) -> String {
    if module.is_empty() { "lib".to_owned() } else { module.join("::") }
}

fn collect(folder: &Path, at: &[String], files: &mut BTreeMap<Module, syn::File>) {
    let mut entries: Vec<_> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let mut module = at.to_vec();
        if path.is_dir() {
            if name != "bin" && name != "tests" {
                module.push(name);
                collect(&path, &module, files);
            }
        } else if path.extension().is_some_and(|e| e == "rs") && name != "tests" && name != "main" {
            if name != "lib" && name != "mod" {
                module.push(name);
            }
            let text = fs::read_to_string(&path).unwrap();
            let file = syn::parse_file(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
            files.insert(module, file);
        }
    }
}

/// Returns the names that a module re-exports, with the path of each.
fn exports(module: &Module, file: &syn::File) -> BTreeMap<String, Module> {
    let mut found = BTreeMap::new();
    for item in &file.items {
        if let syn::Item::Use(u) = item
            && !matches!(u.vis, syn::Visibility::Inherited)
        {
            flatten(&u.tree, &mut Vec::new(), &mut |path, name| {
                if let Some(path) = absolute(module, path) {
                    found.insert(name.to_owned(), path);
                } else {
                    let below = module.iter().chain(path).cloned().collect();
                    found.insert(name.to_owned(), below);
                }
            });
        }
    }
    found
}

/// Calls `each` with the path and the local name of every leaf of a `use`.
fn flatten(tree: &UseTree, path: &mut Vec<String>, each: &mut dyn FnMut(&[String], &str)) {
    match tree {
        UseTree::Path(p) => {
            path.push(p.ident.to_string());
            flatten(&p.tree, path, each);
            path.pop();
        }
        UseTree::Name(n) if n.ident == "self" => {
            each(path, path.last().map_or("", String::as_str));
        }
        UseTree::Name(n) => leaf(&n.ident.to_string(), &n.ident.to_string(), path, each),
        UseTree::Rename(r) if r.ident == "self" => each(path, &r.rename.to_string()),
        UseTree::Rename(r) => leaf(&r.ident.to_string(), &r.rename.to_string(), path, each),
        UseTree::Glob(_) => each(path, "*"),
        UseTree::Group(group) => {
            for tree in &group.items {
                flatten(tree, path, each);
            }
        }
    }
}

fn leaf(name: &str, local: &str, path: &mut Vec<String>, each: &mut dyn FnMut(&[String], &str)) {
    path.push(name.to_owned());
    each(path, local);
    path.pop();
}

/// Returns a path that begins with `crate`, `self` or `super` as one below the crate; of no other path.
fn absolute(at: &Module, path: &[String]) -> Option<Module> {
    let mut base = match path.first()?.as_str() {
        "crate" => Module::new(),
        "self" | "super" => at.clone(),
        _ => return None,
    };
    let ups = path.iter().take_while(|s| *s == "super").count();
    base.truncate(base.len().saturating_sub(ups));
    let skipped = if ups > 0 { ups } else { 1 };
    base.extend(path.iter().skip(skipped).cloned());
    Some(base)
}

/// The modules of the crate, with the names that each re-exports.
struct Known {
    exports: BTreeMap<Module, BTreeMap<String, Module>>,
}

impl Known {
    /// Returns the module that defines the item at a path below the crate.
    fn owner(&self, path: &[String], depth: usize) -> Module {
        let longest = (0..=path.len()).rev().find(|n| self.exports.contains_key(&path[..*n]));
        let module = path[..longest.unwrap_or(0)].to_vec();
        let next = path.get(module.len());
        match next.and_then(|name| self.exports.get(&module)?.get(name)) {
            Some(target) if depth < 8 && !path.starts_with(target) => {
                let rest = path.get(module.len() + 1..).unwrap_or_default();
                let whole: Module = target.iter().chain(rest).cloned().collect();
                self.owner(&whole, depth + 1)
            }
            _ => module,
        }
    }
}

/// Collects the modules that one file names.
struct Names<'a> {
    known: &'a Known,
    /// Module under the cursor, with inline modules.
    at: Module,
    /// Module of the file.
    file: Module,
    found: BTreeSet<Module>,
}

impl Names<'_> {
    fn name(&mut self, path: &[String]) {
        let path = absolute(&self.at, path).or_else(|| {
            let below: Module = self.file.iter().chain(path).cloned().collect();
            let child = below.get(..=self.file.len())?;
            self.known.exports.contains_key(child).then_some(below)
        });
        if let Some(path) = path {
            self.found.insert(self.known.owner(&path, 0));
        }
    }

    fn tokens(&mut self, tokens: TokenStream) {
        let mut path = Vec::new();
        let mut colons = 0;
        for token in tokens {
            match token {
                TokenTree::Ident(ident) => {
                    if colons != 2 {
                        self.end(&mut path);
                    }
                    path.push(ident.to_string());
                    colons = 0;
                }
                TokenTree::Punct(p) if p.as_char() == ':' => colons += 1,
                other => {
                    self.end(&mut path);
                    colons = 0;
                    if let TokenTree::Group(group) = other {
                        self.tokens(group.stream());
                    }
                }
            }
        }
        self.end(&mut path);
    }

    fn end(&mut self, path: &mut Vec<String>) {
        if path.len() > 1 {
            self.name(path);
        }
        path.clear();
    }
}

impl<'ast> Visit<'ast> for Names<'_> {
    fn visit_item_use(&mut self, item: &'ast ItemUse) {
        let mut paths = Vec::new();
        flatten(&item.tree, &mut Vec::new(), &mut |path, _| paths.push(path.to_vec()));
        // A re-export does not count: a module that names it depends on its origin.
        if matches!(item.vis, syn::Visibility::Inherited) && !is_test(&item.attrs) {
            for path in paths {
                self.name(&path);
            }
        }
    }

    fn visit_item_mod(&mut self, item: &'ast ItemMod) {
        if !is_test(&item.attrs) {
            self.at.push(item.ident.to_string());
            visit::visit_item_mod(self, item);
            self.at.pop();
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let names: Vec<_> = path.segments.iter().map(|s| s.ident.to_string()).collect();
        if names.len() > 1 {
            self.name(&names);
        }
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, m: &'ast Macro) {
        self.tokens(m.tokens.clone());
    }
}

fn is_test(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|a| {
        a.path().is_ident("cfg") && a.parse_args::<syn::Ident>().is_ok_and(|i| i == "test")
    })
}
