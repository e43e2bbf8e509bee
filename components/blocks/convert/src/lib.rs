//! Conversions between types, and between numbers and bits.
#![forbid(unsafe_code)]

mod bitmerge;
mod bitslice;
mod conv;
mod gray;
mod narrow;

use conv::Conv;

hal_component::export!(
    bitmerge::Bitmerge,
    bitslice::Bitslice,
    gray::Bin2gray,
    gray::Gray2bin,
    Conv<bool, f64>,
    Conv<bool, i32>,
    Conv<bool, i64>,
    Conv<bool, u32>,
    Conv<bool, u64>,
    Conv<f64, i32>,
    Conv<f64, i64>,
    Conv<f64, u32>,
    Conv<f64, u64>,
    Conv<i32, bool>,
    Conv<i32, f64>,
    Conv<i32, i64>,
    Conv<i32, u32>,
    Conv<i32, u64>,
    Conv<i64, bool>,
    Conv<i64, f64>,
    Conv<i64, i32>,
    Conv<i64, u32>,
    Conv<i64, u64>,
    Conv<u32, bool>,
    Conv<u32, f64>,
    Conv<u32, i32>,
    Conv<u32, i64>,
    Conv<u32, u64>,
    Conv<u64, bool>,
    Conv<u64, f64>,
    Conv<u64, i32>,
    Conv<u64, i64>,
    Conv<u64, u32>,
);
