//! Every component by itself: arguments, pins, pages, examples, properties.

mod arguments;
mod drivers;
mod examples;
mod kinematics;
mod names;
mod pins;
mod properties;
mod recipe;
mod table;
mod units;
