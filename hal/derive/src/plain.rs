//! The derive macro `Plain`.

use crate::field::{doc, fields, span};
use proc_macro2::TokenStream;
use quote::{quote, quote_spanned};
use syn::DeriveInput;

pub(crate) fn plain(ast: &DeriveInput) -> syn::Result<TokenStream> {
    let ty = &ast.ident;
    let (mut counts, mut specs) = (Vec::new(), Vec::new());
    let (mut stores, mut loads) = (Vec::new(), Vec::new());
    let (mut names, mut chosen) = (Vec::new(), Vec::new());
    for f in fields(ast)? {
        let Some(id) = &f.ident else { continue };
        let about = doc(&f.attrs);
        if about.is_empty() {
            return Err(syn::Error::new(
                id.span(),
                format!("field `{id}` needs a doc comment: what it means, with unit and range"),
            ));
        }
        let t = &f.ty;
        let span = span(t);
        let name = id.to_string();
        let name = name.trim_start_matches("r#");
        let bit = names.len();
        chosen.push(quote_spanned!(span=>
            if FIELDS.wrapping_shr(#bit as u32) & 1 == 1 || #bit >= 128 {
                let mut at = at;
                let mut put = |bits| {
                    put(at, bits);
                    at += 1;
                };
                ::hal_component::PlainField::store(&self.#id, &mut put);
            }
            at += <#t as ::hal_component::PlainField>::COUNT;));
        names.push(name.to_owned());
        counts.push(quote_spanned!(span=> <#t as ::hal_component::PlainField>::COUNT));
        specs.push(quote_spanned!(span=> &::hal_component::plain_field::<#t>(#name, #about)));
        stores.push(quote_spanned!(span=>
            ::hal_component::PlainField::store(&self.#id, put);));
        loads.push(quote_spanned!(span=>
            #id: <#t as ::hal_component::PlainField>::load(take)));
    }
    Ok(quote! {
        impl ::hal_component::Plain for #ty {
            const WORDS: usize = 0 #(+ #counts)*;
            const FIELDS: &'static [&'static ::hal_component::abi::FieldSpec] = &[#(#specs),*];
            const NAMES: &'static [&'static str] = &[#(#names),*];
            #[inline]
            fn store(&self, put: &mut impl FnMut(u64)) {
                let _ = &put;
                #(#stores)*
            }
            #[inline]
            fn store_some<const FIELDS: u128>(&self, put: &mut impl FnMut(usize, u64)) {
                let mut at = 0;
                #(#chosen)*
                let _ = (&put, at);
            }
            #[inline]
            fn load(take: &mut impl FnMut() -> u64) -> Self {
                let _ = &take;
                Self { #(#loads),* }
            }
        }
    })
}
