//! Torches and lasers: height, power, rows of pixels.
#![forbid(unsafe_code)]

mod height;
mod laserpower;
mod ohmic;
mod pixels;
mod raster;
mod thc;
mod thcud;

hal_component::export!(
    laserpower::Laserpower,
    ohmic::Ohmic,
    raster::Raster,
    thc::Thc,
    thcud::Thcud
);
