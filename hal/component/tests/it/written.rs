//! Derived code of structs whose field types another macro has written.

use hal_component::{Component, In, Out, Period, Plain, Update};

const OUTPUTS: u32 = 2;

/// Declares a component and a record: name, type and first value of each field, the first one with its type in one piece.
macro_rules! declare {
    ($whole:ident: $ty:ty = $value:tt; $($name:ident: $pin:ident<$word:ident> = $first:tt;)*) => {
        /// Combines its inputs.
        #[derive(Component)]
        struct Combined {
            $(
                /// Input.
                #[hal(default = $first)]
                $name: $pin<$word>,
            )*
            /// Input with its type in one piece.
            #[hal(default = $value)]
            $whole: $ty,
            /// Outputs.
            #[hal(name = "out-#", count = OUTPUTS)]
            outputs: Vec<Out<bool>>,
        }

        #[derive(Clone, Copy, Plain)]
        struct Record {
            $(
                /// Word.
                $name: $word,
            )*
        }
    };
}

declare!(whole: In<u32> = 9; number: In<u32> = 7; is_open: In<bool> = true;);

impl Update for Combined {
    fn update(&mut self, _: Period) {
        let all = self.is_open.get() && self.number.get() == self.whole.get();
        self.outputs.iter().for_each(|out| out.set(all));
    }
}

#[test]
fn written_types_give_pins_and_words() {
    let items = Combined::ITEMS.iter().map(|item| item.initial);
    assert_eq!(items.collect::<Vec<_>>(), [7, 1, 9]);
    let mut words = Vec::new();
    Record { number: 7, is_open: true }.store(&mut |bits| words.push(bits));
    assert_eq!(words, [7, 1]);
}
