//! Torches and lasers: height, power, rows of pixels.
#![forbid(unsafe_code)]

mod height;
mod laserpower;
mod ohmic;
mod pixels;
mod plasmac;
mod raster;
mod thc;
mod thcud;

hal_component::export!(
    laserpower::Laserpower,
    ohmic::Ohmic,
    plasmac::Plasmac,
    raster::Raster,
    thc::Thc,
    thcud::Thcud
);
