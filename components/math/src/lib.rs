//! Arithmetic, limits and comparisons.
#![forbid(unsafe_code)]

mod abs;
mod abs_s32;
mod bounds;
mod comp;
mod ddt;
mod deadzone;
mod div2;
mod hypot;
mod integ;
mod invert;
mod limit1;
mod limit2;
mod limit3;
mod lowpass;
mod minmax;
mod mult2;
mod near;
mod offset;
mod scale;
mod sum2;
mod wcomp;

hal_component::export!(
    abs::Abs,
    abs_s32::AbsS32,
    comp::Comp,
    ddt::Ddt,
    deadzone::Deadzone,
    div2::Div2,
    hypot::Hypot,
    integ::Integ,
    invert::Invert,
    limit1::Limit1,
    limit2::Limit2,
    limit3::Limit3,
    lowpass::Lowpass,
    minmax::Minmax,
    mult2::Mult2,
    near::Near,
    offset::Offset,
    scale::Scale,
    sum2::Sum2,
    wcomp::Wcomp,
);
