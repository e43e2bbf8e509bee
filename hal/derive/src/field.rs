//! Fields of a struct and their attributes.

use proc_macro2::Span;
use syn::{
    Attribute, Data, DeriveInput, Expr, Field, Fields, Lit, LitStr, Meta, Type, spanned::Spanned,
};

/// Contents of `#[hal(…)]`.
#[derive(Default)]
pub(crate) struct Hal {
    pub(crate) name: Option<String>,
    pub(crate) function: Option<String>,
    pub(crate) default: Option<Expr>,
    pub(crate) count: Option<Expr>,
    pub(crate) fast: bool,
    pub(crate) personality: bool,
    pub(crate) safety: bool,
}

impl Hal {
    pub(crate) fn read(attrs: &[Attribute]) -> syn::Result<Self> {
        let mut out = Self::default();
        for a in attrs.iter().filter(|a| a.path().is_ident("hal")) {
            a.parse_nested_meta(|m| {
                let text = || Ok::<_, syn::Error>(Some(m.value()?.parse::<LitStr>()?.value()));
                match m.path.get_ident().map(ToString::to_string).as_deref() {
                    Some("name") => out.name = text()?,
                    Some("function") => out.function = text()?,
                    Some("default") => out.default = Some(m.value()?.parse()?),
                    Some("count") => out.count = Some(m.value()?.parse()?),
                    Some("fast") => out.fast = true,
                    Some("personality") => out.personality = true,
                    Some("safety") => out.safety = true,
                    _ => {
                        return Err(m.error(
                            "expected `name`, `function`, `default`, `count`, `fast`, \
                             `personality` or `safety`",
                        ));
                    }
                }
                Ok(())
            })?;
        }
        Ok(out)
    }
}

pub(crate) fn fields(ast: &DeriveInput) -> syn::Result<impl Iterator<Item = &Field>> {
    match &ast.data {
        Data::Struct(data) => match &data.fields {
            Fields::Named(named) => Ok(named.named.iter()),
            Fields::Unnamed(_) | Fields::Unit => Err(unnamed(ast)),
        },
        Data::Enum(_) | Data::Union(_) => Err(unnamed(ast)),
    }
}

fn unnamed(ast: &DeriveInput) -> syn::Error {
    let ty = &ast.ident;
    let text = format!("pins have names: write `struct {ty} {{ … }}` with a field for each");
    syn::Error::new(ty.span(), text)
}

pub(crate) fn is_state(f: &Field) -> bool {
    f.attrs.iter().any(|a| a.path().is_ident("state"))
}

/// Returns the span of code for a field of this type: errors show the type, and names are those of the derive macro, also
/// where another macro has written the type.
pub(crate) fn span(t: &Type) -> Span {
    t.span().resolved_at(Span::call_site())
}

pub(crate) fn doc(attrs: &[Attribute]) -> String {
    let lines = attrs.iter().filter_map(|a| match &a.meta {
        Meta::NameValue(nv) if nv.path.is_ident("doc") => match &nv.value {
            Expr::Lit(l) => match &l.lit {
                Lit::Str(s) => Some(s.value().trim().to_owned()),
                _ => None,
            },
            _ => None,
        },
        _ => None,
    });
    lines.collect::<Vec<_>>().join("\n").trim().to_owned()
}
