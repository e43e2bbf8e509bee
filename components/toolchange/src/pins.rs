//! The pins `iocontrol.0.*`.

use hal_component::{Builder, Decl, Error, Field, In, Out, Touch};

macro_rules! pins {
    ($($(#[doc = $doc:literal])+
        $field:ident: $ty:ty = $initial:expr, $pin:literal $([$safety:ident])?;)*
    ) => {
        /// All of them.
        #[derive(Clone, Copy, Debug, Touch)]
        pub(crate) struct Pins {
            $($(#[doc = $doc])+ pub(crate) $field: $ty,)*
        }

        impl Pins {
            pub(crate) fn make(b: &mut Builder<'_>) -> Result<Self, Error> {
                Ok(Self {
                    $($field: {
                        let decl = Decl::new(
                            concat!("iocontrol.0.", $pin),
                            concat!($($doc),+).trim_ascii(),
                        )$(.$safety())?;
                        <$ty>::make(b, decl, $initial)?
                    },)*
                })
            }
        }
    };
}

pins! {
    /// TRUE while no e-stop is commanded: enables the chain of e-stop contacts.
    user_enable_out: Out<bool> = false, "user-enable-out";
    /// TRUE for one cycle when e-stop is reset: its edge resets a latch outside.
    user_request_enable: Out<bool> = false, "user-request-enable";
    /// FALSE while the machine is in e-stop, for whatever reason.
    emc_enable_in: In<bool> = false, "emc-enable-in" [safety];
    /// TRUE while mist coolant is wanted; FALSE in e-stop.
    coolant_mist: Out<bool> = false, "coolant-mist";
    /// TRUE while flood coolant is wanted; FALSE in e-stop.
    coolant_flood: Out<bool> = false, "coolant-flood";
    /// TRUE while lubrication is wanted; FALSE in e-stop.
    lube: Out<bool> = false, "lube";
    /// FALSE when the lubricant runs low. Nothing follows from it.
    lube_level: In<bool> = true, "lube_level";
    /// TRUE asks the changer to prepare the tool of tool-prep-number, until tool-prepared.
    tool_prepare: Out<bool> = false, "tool-prepare";
    /// TRUE from the changer when the tool is prepared.
    tool_prepared: In<bool> = false, "tool-prepared";
    /// TRUE asks the changer to put the prepared tool into the spindle, until tool-changed.
    tool_change: Out<bool> = false, "tool-change";
    /// TRUE from the changer when the tool is in the spindle.
    tool_changed: In<bool> = false, "tool-changed";
    /// Number of the tool being prepared or prepared; 0 for none, and after it was changed.
    tool_prep_number: Out<i32> = 0, "tool-prep-number";
    /// Pocket of the tool being prepared or prepared; 0 for none, and after it was changed.
    tool_prep_pocket: Out<i32> = 0, "tool-prep-pocket";
    /// Place in the tool table of the tool being prepared or prepared; 0 for none, and after it
    /// was changed.
    tool_prep_index: Out<i32> = 0, "tool-prep-index";
    /// Pocket that the tool in the spindle came from.
    tool_from_pocket: Out<i32> = 0, "tool-from-pocket";
    /// Number of the tool in the spindle; 0 for none.
    tool_number: Out<i32> = 0, "tool-number";
}
