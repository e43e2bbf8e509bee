//! Arithmetic, limits and comparisons.
#![forbid(unsafe_code)]

mod abs;
mod abs_s32;
mod abs_s64;
mod bounds;
mod comp;
mod constant;
mod ddt;
mod deadzone;
mod div2;
mod hypot;
mod integ;
mod invert;
mod limit1;
mod limit2;
mod limit3;
mod limit_axis;
mod lincurve;
mod lowpass;
mod minmax;
mod modmath;
mod mult2;
mod near;
mod offset;
mod scale;
mod scaled_s32_sums;
mod sum2;
mod wcomp;
mod weighted_sum;

hal_component::export!(
    abs::Abs,
    abs_s32::AbsS32,
    abs_s64::AbsS64,
    comp::Comp,
    constant::Constant,
    ddt::Ddt,
    deadzone::Deadzone,
    div2::Div2,
    hypot::Hypot,
    integ::Integ,
    invert::Invert,
    limit1::Limit1,
    limit2::Limit2,
    limit3::Limit3,
    limit_axis::LimitAxis,
    lincurve::Lincurve,
    lowpass::Lowpass,
    minmax::Minmax,
    modmath::Modmath,
    mult2::Mult2,
    near::Near,
    offset::Offset,
    scale::Scale,
    scaled_s32_sums::ScaledS32Sums,
    sum2::Sum2,
    wcomp::Wcomp,
    weighted_sum::WeightedSum,
);
