//! Pins `iocontrol.0.*`.

use hal_component::{Builder, Decl, Error, Field, In, Out, Touch};

macro_rules! pins {
    ($($(#[doc = $doc:literal])+
        $field:ident: $ty:ty = $initial:expr, $pin:literal $([$safety:ident])?;)*
    ) => {
        /// All pins of iocontrol.
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
    /// TRUE while no e-stop is commanded: enables the e-stop chain.
    user_enable_out: Out<bool> = false, "user-enable-out";
    /// TRUE for one cycle when e-stop is reset: its edge resets an external latch.
    user_request_enable: Out<bool> = false, "user-request-enable";
    /// FALSE while the machine is in e-stop, for any reason.
    emc_enable_in: In<bool> = false, "emc-enable-in" [safety];
    /// TRUE to switch mist coolant on; FALSE in e-stop.
    coolant_mist: Out<bool> = false, "coolant-mist";
    /// TRUE to switch flood coolant on; FALSE in e-stop.
    coolant_flood: Out<bool> = false, "coolant-flood";
    /// TRUE to switch lubrication on; FALSE in e-stop.
    lube: Out<bool> = false, "lube";
    /// FALSE when the lubricant runs low. Has no effect.
    lube_level: In<bool> = true, "lube_level";
    /// TRUE requests the changer to prepare the tool of tool-prep-number, until tool-prepared.
    tool_prepare: Out<bool> = false, "tool-prepare";
    /// TRUE from the changer when the tool is prepared.
    tool_prepared: In<bool> = false, "tool-prepared";
    /// TRUE requests the changer to put the prepared tool into the spindle, until tool-changed.
    tool_change: Out<bool> = false, "tool-change";
    /// TRUE from the changer when the tool is in the spindle.
    tool_changed: In<bool> = false, "tool-changed";
    /// Number of the tool being prepared or prepared; 0 for none, and after the change.
    tool_prep_number: Out<i32> = 0, "tool-prep-number";
    /// Pocket of the tool being prepared or prepared; 0 for none, and after the change.
    tool_prep_pocket: Out<i32> = 0, "tool-prep-pocket";
    /// Index in the tool table of the tool being prepared or prepared; 0 for none, and after the change.
    tool_prep_index: Out<i32> = 0, "tool-prep-index";
    /// Pocket that the tool in the spindle came from; -1 if it is unknown.
    tool_from_pocket: Out<i32> = 0, "tool-from-pocket";
    /// Number of the tool in the spindle; 0 for none, -1 if it is unknown because a change was interrupted.
    tool_number: Out<i32> = 0, "tool-number";
}
