//! Groups of pins, and inputs of which changes count.

use hal_component::{In, Out, Touch, Uses};

/// Declares a group of pins: a struct with a function that makes it, from a prefix of the names.
macro_rules! group {
    ($(#[$about:meta])* $name:ident { $($(#[doc = $doc:literal])+
        $field:ident: $ty:ty = $initial:expr, $pin:literal;)* }
    ) => {
        $(#[$about])*
        #[derive(Clone, Debug, hal_component::Touch)]
        pub(crate) struct $name {
            $($(#[doc = $doc])+ pub(crate) $field: $ty,)*
        }

        impl $name {
            pub(crate) fn make(
                b: &mut hal_component::Builder<'_>,
                prefix: &str,
            ) -> Result<Self, hal_component::Error> {
                Ok(Self {
                    $($field: {
                        let name = format!("{prefix}{}", $pin);
                        let doc = concat!($($doc),+).trim_ascii();
                        <$ty as $crate::pins::Made<_>>::made(b, &name, doc, $initial)?
                    },)*
                })
            }
        }
    };
}
pub(crate) use group;

/// A pin, or an input of which changes count.
pub(crate) trait Made<T>: Sized {
    fn made(
        b: &mut hal_component::Builder<'_>,
        name: &str,
        doc: &str,
        initial: T,
    ) -> Result<Self, hal_component::Error>;
}

/// Lets a pin be made, whatever its type.
macro_rules! made {
    ($($pin:ident)*) => {$(
        impl<T: hal_component::Value> Made<T> for $pin<T> {
            fn made(
                b: &mut hal_component::Builder<'_>,
                name: &str,
                doc: &str,
                initial: T,
            ) -> Result<Self, hal_component::Error> {
                b.item(name, doc, initial)
            }
        }
    )*};
}
made! { In Out }

impl Made<bool> for Button {
    fn made(
        b: &mut hal_component::Builder<'_>,
        name: &str,
        doc: &str,
        initial: bool,
    ) -> Result<Self, hal_component::Error> {
        Ok(Self { pin: b.item(name, doc, initial)?, before: None })
    }
}

impl Made<i32> for Counter {
    fn made(
        b: &mut hal_component::Builder<'_>,
        name: &str,
        doc: &str,
        initial: i32,
    ) -> Result<Self, hal_component::Error> {
        Ok(Self { pin: b.item(name, doc, initial)?, before: None })
    }
}

/// A button. A pin that is TRUE at the first look was not pressed.
#[derive(Clone, Debug)]
pub(crate) struct Button {
    pin: In<bool>,
    before: Option<bool>,
}

impl Button {
    /// Returns whether the button was pressed since the last call.
    pub(crate) fn is_pressed(&mut self) -> bool {
        let now = self.pin.get();
        self.before.replace(now) == Some(false) && now
    }
}

impl Touch for Button {
    fn touch(&self, uses: &mut Uses) {
        self.pin.touch(uses);
    }
}

/// Counts of a wheel.
#[derive(Clone, Debug)]
pub(crate) struct Counter {
    pin: In<i32>,
    before: Option<i32>,
}

impl Counter {
    pub(crate) fn get(&self) -> i32 {
        self.pin.get()
    }

    /// Returns the change since the last call. Counts wrap.
    pub(crate) fn change(&mut self) -> i32 {
        let now = self.pin.get();
        now.wrapping_sub(self.before.replace(now).unwrap_or(now))
    }
}

impl Touch for Counter {
    fn touch(&self, uses: &mut Uses) {
        self.pin.touch(uses);
    }
}
