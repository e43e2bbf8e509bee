//! `keeps`, from its .comp file: the declaration is whole, the C text is to be translated.
#![forbid(unsafe_code)]

use hal_component::{Component, In, Out, Period, Update};

/// Variables: of several types, arrays, pointers, with first values and without.
#[expect(dead_code, reason = "the C text is still to be translated")]
#[derive(Component)]
struct Keeps {
    /// Pin `in`; the C file does not say what it means.
    in_: In<f64>,
    /// Of the last four.
    mean: Out<f64>,
    /// Pin `runs`; the C file does not say what it means.
    runs: Out<i32>,
    /// Pin `same`; the C file does not say what it means.
    same: Out<bool>,
    #[state]
    #[hal(default = [1.0; 4])]
    ring: [f64; 4],
    #[state]
    at: i32,
    #[state]
    #[hal(default = 10)]
    so_far: u64,
    // To be chosen: double *newest;
    // To be chosen: const char **unused;
    #[state]
    #[hal(default = 3)]
    kept: u32,
}

impl Update for Keeps {
    fn update(&mut self, _period: Period) {
        // To be translated:
        //
        //         double all = 0;
        //         int i;
        //         ring[at] = in;
        //         newest = &ring[at];
        //         at = (at + 1) % 4;
        //         for (i = 0; i < 4; i++) all += ring[i];
        //         mean = all / 4;
        //         so_far++;
        //         runs = (int)so_far + (int)kept;
        //         same = *newest == in && unused == 0;
    }
}

hal_component::export!(Keeps);
