//! Components that fail on request.

mod alloc;
mod boom;
mod busy;
mod chatty;
mod deep;
mod doomed;
mod foreign;
mod last_words;
mod lazy;
mod mover;
mod person;
mod quits;
mod swap;
mod talk;
mod tap;
mod witness;

hal_component::export!(
    alloc::Alloc,
    boom::Boom,
    busy::Busy,
    busy::Stuck,
    chatty::Chatty,
    deep::Deep,
    doomed::Doomed,
    foreign::Foreign,
    last_words::LastWords,
    lazy::Lazy,
    mover::Mover,
    person::Person,
    quits::Quits,
    swap::Swap,
    talk::Listener,
    talk::Talker,
    tap::Feed,
    tap::Tap,
    witness::Witness,
);
