//! Structs of pins for components that declare their pins by hand.

/// Defines a struct of pins and parameters that can create itself. Use it for components whose
/// instances are not those of `count=` and `names=`.
///
/// The doc comment of a field is shown to users. It is followed by the field's type, pin name and
/// initial value, and by words such as `measured` or `safety`, methods of [`Decl`](crate::Decl).
///
/// ```
/// use hal_component::{In, Out, pins};
///
/// pins! {
///     /// One channel.
///     struct Channel {
///         /// The number to follow, in units.
///         command: In<f64> = "command", 0.0;
///         /// True while it is there.
///         is_there: Out<bool> = "is-there", true;
///     }
/// }
/// // In `create`: `Channel::make(b, "loop.0")?` declares `loop.0.command` and `loop.0.is-there`.
/// ```
#[macro_export]
macro_rules! pins {
    (
        $(#[$about:meta])*
        $vis:vis struct $name:ident {
            $($(#[doc = $doc:literal])+ $field:ident: $ty:ty = $pin:literal, $initial:expr
                $(, $flag:ident)*;)+
        }
    ) => {
        $(#[$about])*
        #[derive(Clone, Debug, $crate::Touch)]
        $vis struct $name {
            $($(#[doc = $doc])+ pub(crate) $field: $ty,)+
        }
        impl $name {
            /// Creates all pins. Puts `prefix` and a dot before each name.
            ///
            /// # Errors
            /// A name is taken or too long.
            pub(crate) fn make(
                b: &mut $crate::Builder<'_>,
                prefix: &str,
            ) -> ::core::result::Result<Self, $crate::Error> {
                ::core::result::Result::Ok(Self {
                    $($field: $crate::Field::make(
                        b,
                        $crate::Decl::new(
                            &$crate::pin_name(prefix, $pin),
                            &$crate::pin_doc(&[$($doc),+]),
                        )$(.$flag())*,
                        $initial,
                    )?,)+
                })
            }
        }
    };
}

/// Returns the full name of a pin. An empty prefix adds nothing.
#[doc(hidden)]
#[must_use]
pub fn pin_name(prefix: &str, pin: &str) -> String {
    if prefix.is_empty() { pin.to_owned() } else { format!("{prefix}.{pin}") }
}

/// Joins the lines of a doc comment.
#[doc(hidden)]
#[must_use]
pub fn pin_doc(lines: &[&str]) -> String {
    lines.iter().map(|l| l.trim()).collect::<Vec<_>>().join("\n")
}
