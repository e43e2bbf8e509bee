//! Classes of requests.

/// Declares the requests by class: [`crate::Request`], the class of each, and an enum of the requests of each class, so
/// that the code for a class matches all of its requests and no others.
macro_rules! requests {
    ($(
        $(#[$class_meta:meta])*
        $class:ident: $of_class:ident {
            $(
                $(#[$meta:meta])*
                $name:ident
                $(($spec:ident: $spec_ty:ty))?
                $({ $($(#[$field_meta:meta])* $field:ident: $ty:ty),* $(,)? })?
            ),* $(,)?
        }
    )*) => {
        /// A request of a client.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum Request {
            $($(
                $(#[$meta])*
                $name $(($spec_ty))? $({ $($(#[$field_meta])* $field: $ty),* })?,
            )*)*
        }

        /// Class of a request: the part of an engine that handles it.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Class {
            $($(#[$class_meta])* $class,)*
        }

        /// A request with its class.
        #[derive(Clone, Debug, PartialEq)]
        pub enum ByClass {
            $($(#[$class_meta])* $class($of_class),)*
        }

        $(
            $(#[$class_meta])*
            #[derive(Clone, Debug, PartialEq)]
            #[expect(missing_docs, reason = "they are documented as requests of the same names")]
            pub enum $of_class {
                $($name $(($spec_ty))? $({ $($field: $ty),* })?,)*
            }
        )*

        impl Request {
            /// Returns the class of this request.
            #[must_use]
            pub const fn class(&self) -> Class {
                match self {
                    $($(Self::$name { .. } => Class::$class,)*)*
                }
            }

            /// Returns this request as one of its class.
            #[must_use]
            pub fn by_class(self) -> ByClass {
                match self {
                    $($(
                        Self::$name $(($spec))? $({ $($field),* })? => {
                            ByClass::$class($of_class::$name $(($spec))? $({ $($field),* })?)
                        }
                    )*)*
                }
            }
        }
    };
}

pub(crate) use requests;
