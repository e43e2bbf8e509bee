//! Self-description of a component type, before an instance of it exists.

use crate::load::args::Declared;
use hal_abi::{ComponentType, component_flags};
use hal_protocol::{ArgInfo, Bounds, Offer};

/// Arguments that `loadrt` itself takes for components with instances.
const COUNT: (&str, &str, &str) =
    ("count", "int", "How many instances, named after the component with a number.");
const NAMES: (&str, &str, &str) = ("names", "texts", "The names of the instances, one for each.");
const PERSONALITY: (&str, &str, &str) = (
    "personality",
    "ints",
    "What each instance is like, a number for each, as the description tells; 0 where the list is \
     shorter.",
);

/// Describes the type `ty` of an open library.
pub(crate) fn of(name: &str, library: &str, ty: &ComponentType) -> Offer {
    // SAFETY: a string of an open library's descriptor.
    let doc = unsafe { ty.doc.get() }.unwrap_or_default().to_owned();
    let mut args: Vec<ArgInfo> = (0..ty.args.len())
        // SAFETY: a list of an open library's descriptor.
        .filter_map(|i| unsafe { ty.args.get(i) })
        .filter_map(|spec| Declared::copy(&spec))
        .map(|declared| declared.info())
        .collect();
    if ty.flags & component_flags::ONCE == 0 {
        args.extend([plain(COUNT), plain(NAMES)]);
        if ty.flags & component_flags::PERSONALITY != 0 {
            args.push(plain(PERSONALITY));
        }
    }
    Offer { component: name.to_owned(), library: library.to_owned(), doc, args }
}

fn plain((name, ty, doc): (&str, &str, &str)) -> ArgInfo {
    ArgInfo {
        name: name.to_owned(),
        ty: ty.to_owned(),
        doc: doc.to_owned(),
        required: false,
        default: None,
        bounds: Bounds::default(),
        unit: String::new(),
    }
}
