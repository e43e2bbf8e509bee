//! The derive macros `Component` and `Touch`.

use crate::field::{Hal, doc, fields, is_state, span};
use proc_macro2::TokenStream;
use quote::{quote, quote_spanned};
use syn::{DeriveInput, Expr, spanned::Spanned};

pub(crate) fn component(ast: &DeriveInput) -> syn::Result<TokenStream> {
    let ty = &ast.ident;
    let hal = Hal::read(&ast.attrs)?;
    let name = hal.name.clone().unwrap_or_else(|| snake(&ty.to_string()));
    let about = doc(&ast.attrs);
    if about.is_empty() {
        return Err(syn::Error::new(
            ty.span(),
            "a component needs a doc comment: `/// What it does.` above the struct",
        ));
    }
    let (mut inits, mut items) = (Vec::new(), Vec::new());
    // The argument of `create`, also where another macro has written the type of a field. The other names keep the span of
    // the type, so that errors show it alone.
    let b = quote!(b);
    for f in fields(ast)? {
        let Some(id) = &f.ident else { continue };
        let field = Hal::read(&f.attrs)?;
        let value = field.default.clone();
        if is_state(f) {
            let t = &f.ty;
            let value = value.map_or_else(
                || quote_spanned!(t.span()=> <#t as ::hal_component::Begins>::begin()),
                |value| quote!(#value),
            );
            inits.push(quote!(#id: #value));
            continue;
        }
        let about = doc(&f.attrs);
        if about.is_empty() {
            return Err(syn::Error::new(
                id.span(),
                format!("pin `{id}` needs a doc comment: what it means, with unit and range"),
            ));
        }
        let pin = field.name.clone().unwrap_or_else(|| hal_name(&id.to_string()));
        let t = &f.ty;
        let value = value.unwrap_or_else(|| syn::parse_quote!(Default::default()));
        let safety = field.safety.then(|| quote!(.safety()));
        if let Some(count) = &field.count {
            let (before, width, after) = hashes(&pin, id)?;
            inits.push(quote_spanned! {t.span()=> #id: {
                let n = (#count) as usize;
                let mut list = ::std::vec::Vec::with_capacity(n);
                for i in 0..n {
                    let name = ::std::format!("{}{:0w$}{}", #before, i, #after, w = #width);
                    let decl = ::hal_component::Decl::new(&name, #about)#safety;
                    list.push(::hal_component::Field::make(#b, decl, #value)?);
                }
                list
            }});
            continue;
        }
        inits.push(quote_spanned! {t.span()=>
            #id: <#t as ::hal_component::Field>::make(
                #b, ::hal_component::Decl::new(#pin, #about)#safety, #value)?
        });
        items.push(item(t, &pin, &about, field.default.as_ref(), field.safety));
    }
    let function = hal.function.unwrap_or_default();
    let add = if hal.fast { quote!(fast_function) } else { quote!(function) };
    let personality = if hal.personality {
        quote!(::hal_component::abi::component_flags::PERSONALITY)
    } else {
        quote!(0)
    };
    let touches = touch(ast)?;
    let summary = about.lines().next().unwrap_or_default();
    Ok(quote! {
        impl ::hal_component::Component for #ty {
            const NAME: &'static str = #name;
            const DOC: &'static str = #about;
            const FLAGS: u32 = #personality | ::hal_component::abi::component_flags::PARALLEL;
            const ITEMS: &'static [&'static ::hal_component::abi::ItemSpec] = &[#(#items),*];
            fn create(
                b: &mut ::hal_component::Builder<'_>,
            ) -> ::core::result::Result<(), ::hal_component::Error> {
                let instance = Self { #(#inits),* };
                b.#add(#function, #summary, instance)
            }
        }
        #touches
    })
}

/// Returns the error together with empty implementations, so that the author sees no errors that
/// only follow from it.
pub(crate) fn refused(ast: &DeriveInput, error: &syn::Error) -> TokenStream {
    let (ty, error) = (&ast.ident, error.to_compile_error());
    let (impls, generics, wheres) = ast.generics.split_for_impl();
    quote! {
        #error
        impl #impls ::hal_component::Component for #ty #generics #wheres {
            const NAME: &'static str = "";
            const DOC: &'static str = "";
            fn create(
                b: &mut ::hal_component::Builder<'_>,
            ) -> ::core::result::Result<(), ::hal_component::Error> {
                ::core::result::Result::Ok(())
            }
        }
        impl #impls ::hal_component::Touch for #ty #generics #wheres {
            fn touch(&self, _: &mut ::hal_component::Uses) {}
        }
    }
}

/// Returns the static declaration of an item, for tools that read a library without running it.
fn item(
    t: &syn::Type,
    pin: &str,
    about: &str,
    default: Option<&Expr>,
    safety: bool,
) -> TokenStream {
    let initial = default.map_or_else(|| quote!(0), |value| bits(t, value));
    let flags = if safety { quote!(::hal_component::abi::item_flags::SAFETY) } else { quote!(0) };
    quote_spanned! {t.span()=> &::hal_component::abi::ItemSpec {
        size: ::hal_component::abi::size::<::hal_component::abi::ItemSpec>(),
        flags: #flags,
        name: ::hal_component::abi::Str::new(#pin),
        doc: ::hal_component::abi::Str::new(#about),
        old_name: ::hal_component::abi::Str::NONE,
        initial: #initial,
        storage: ::core::ptr::null_mut(),
        ty: <#t as ::hal_component::Field>::TYPE,
        dir: <#t as ::hal_component::Field>::DIR,
    }}
}

/// Returns a default as bits of a cell, computed at compile time. The last type argument gives the
/// type.
fn bits(t: &syn::Type, value: &Expr) -> TokenStream {
    let inner = match t {
        // A type that another macro has passed on.
        syn::Type::Group(group) => return bits(&group.elem, value),
        syn::Type::Path(p) => p.path.segments.last().and_then(|s| match &s.arguments {
            syn::PathArguments::AngleBracketed(a) => a.args.first().map(|a| quote!(#a).to_string()),
            _ => None,
        }),
        _ => None,
    };
    match inner.as_deref() {
        Some("bool") => quote!({ const V: bool = #value; V as u64 }),
        Some("f64") => quote!({ const V: f64 = #value; V.to_bits() }),
        Some("i32") => quote!({ const V: i32 = #value; V.cast_unsigned() as u64 }),
        Some("u32") => quote!({ const V: u32 = #value; V as u64 }),
        Some("i64") => quote!({ const V: i64 = #value; V.cast_unsigned() }),
        Some("u64") => quote!({ const V: u64 = #value; V }),
        _ => quote!(0),
    }
}

pub(crate) fn touch(ast: &DeriveInput) -> syn::Result<TokenStream> {
    let ty = &ast.ident;
    let (impls, generics, wheres) = ast.generics.split_for_impl();
    let mut each = Vec::new();
    for f in fields(ast)? {
        if let (Some(id), false) = (&f.ident, is_state(f)) {
            let t = &f.ty;
            each.push(quote_spanned!(span(t)=>
                <#t as ::hal_component::Touch>::touch(&self.#id, uses);));
        }
    }
    Ok(quote! {
        impl #impls ::hal_component::Touch for #ty #generics #wheres {
            fn touch(&self, uses: &mut ::hal_component::Uses) {
                let _ = &uses;
                #(#each)*
            }
        }
    })
}

/// Splits `in-##` into the part before (`in-`), the width (2) and the part after (empty).
fn hashes(pin: &str, at: &syn::Ident) -> syn::Result<(String, usize, String)> {
    let missing = || {
        syn::Error::new(
            at.span(),
            "a list of pins needs its number in the name: `name = \"in-##\"`",
        )
    };
    let start = pin.find('#').ok_or_else(missing)?;
    let (before, rest) = pin.split_at(start);
    let after = rest.trim_start_matches('#');
    Ok((before.to_owned(), rest.len() - after.len(), after.to_owned()))
}

/// Converts a field name to a pin name by LinuxCNC's rule: `min_` becomes `min`, `in_pos` becomes
/// `in-pos`.
fn hal_name(ident: &str) -> String {
    ident.trim_start_matches("r#").replace('_', "-").trim_end_matches(['-', '.']).to_owned()
}

/// Converts a type name: `SimEncoder` becomes `sim_encoder`.
fn snake(ident: &str) -> String {
    let mut out = String::new();
    for (i, c) in ident.chars().enumerate() {
        if c.is_ascii_uppercase() && i > 0 {
            out.push('_');
        }
        out.push(c.to_ascii_lowercase());
    }
    out
}
