//! Operator panels: knobs, buttons, keyboards, displays and messages.
#![forbid(unsafe_code)]

mod joyhandle;
mod knob2float;
mod lcd;
mod led_dim;
mod matrix_kb;
mod message;
mod nist;
mod xhc_hb04_util;

hal_component::export!(
    joyhandle::Joyhandle,
    knob2float::Knob2float,
    lcd::Lcd,
    led_dim::LedDim,
    matrix_kb::MatrixKb,
    message::Message,
    nist::Momentary2nist,
    nist::Toggle2nist,
    xhc_hb04_util::XhcHb04Util,
);
