//! `width_of`, from its .comp file: the declaration is whole, the C text is to be translated.
#![forbid(unsafe_code)]

use hal_component::{Component, Error, In, Out, Period, Update};

/// As many inputs as its personality says.
#[derive(Component)]
#[hal(personality)]
struct WidthOf {
    /// Pin `in-##`; the C file does not say what it means.
    #[hal(name = "in-##", count = at_most(16, b.personality())?)]
    in_: Vec<In<bool>>,
    /// Inputs as a number, in-00 lowest.
    number: Out<u32>,
}

impl Update for WidthOf {
    fn update(&mut self, _period: Period) {
        // To be translated:
        //
        //         unsigned all = 0;
        //         int i;
        //         for (i = 0; i < personality; i++)
        //             if (in(i)) all |= 1u << i;
        //         number = all;
    }
}

/// The size of a list; more than there can be is refused.
fn at_most(most: i64, wanted: i64) -> Result<i64, Error> {
    if wanted > most {
        return Err(Error::new(format!("Requested size {wanted} exceeds max size {most}")));
    }
    Ok(wanted.max(0))
}

hal_component::export!(WidthOf);
