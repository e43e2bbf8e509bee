//! Derive macros of `hal-component`; see that crate.

mod component;
mod field;
mod plain;

use proc_macro::TokenStream;

/// Turns a struct of pins, parameters and state into a component with one function.
///
/// On the struct: `#[hal(name = "type_name", function = "update", fast, personality)]`, all
/// optional. The default name is the struct's name in snake case. On a field:
/// `#[hal(name = "in-##", default = 1.0, count = b.personality(), safety)]`, or `#[state]` with an
/// optional `#[hal(default = …)]`. A name with `#` and a count makes a list of pins. Every pin and
/// parameter needs a doc comment, which is shown to users.
#[proc_macro_derive(Component, attributes(hal, state))]
pub fn component(input: TokenStream) -> TokenStream {
    let ast = syn::parse_macro_input!(input as syn::DeriveInput);
    component::component(&ast).unwrap_or_else(|e| component::refused(&ast, &e)).into()
}

/// Implements `Touch`, which declares the pins, parameters and hidden state that a function
/// accesses: all fields that are not `#[state]`.
#[proc_macro_derive(Touch, attributes(hal, state))]
pub fn touch(input: TokenStream) -> TokenStream {
    component::touch(&syn::parse_macro_input!(input as syn::DeriveInput))
        .unwrap_or_else(|e| e.to_compile_error())
        .into()
}

/// Implements `Plain` for a struct of pin values and arrays of them. Every field needs a doc
/// comment, which is shown to users of a snapshot.
#[proc_macro_derive(Plain)]
pub fn plain(input: TokenStream) -> TokenStream {
    plain::plain(&syn::parse_macro_input!(input as syn::DeriveInput))
        .unwrap_or_else(|e| e.to_compile_error())
        .into()
}
