//! The check of the socket: requests that have arrived are executed, waits that are over are answered.

use crate::{
    Engine,
    serve::client::{Client, WaitState},
    serve::pins::{exchange_due, next_exchange},
    serve::polls::{clients_target, next_poll_of, settle},
    serve::server::wait_only,
    serve::session::{forget_left, leave, respond},
};

/// Largest number of requests of one client that are executed before the next client's turn.
const MAX_IN_TURN: usize = 16;

/// Checks the socket once: waits at most `ms` milliseconds for something to do, and does it.
pub(crate) fn serve_once(engine: &mut Engine, ms: i32) {
    if !engine.model.departed().is_empty() && !engine.runtime.is_inside() {
        forget_left(engine);
    }
    let Some(mut server) = engine.clients.server.take() else { return wait_only(ms) };
    let mut ms = server.wait_ms(ms);
    if !engine.runtime.is_virtual() {
        let due = engine.runtime.next_task().min(next_poll_of(&server));
        let due = due.min(next_exchange(&server.clients)) - engine.runtime.now();
        ms = ms.min(i32::try_from(due / 1_000_000 + 1).unwrap_or(i32::MAX).max(0));
        if server.clients.iter().any(|c| matches!(c.waits, WaitState::Ticket(_))) {
            ms = ms.min(1);
        }
        if engine.observers.is_recording() || engine.observers.is_flight_on() {
            ms = ms.min(5);
        }
    }
    server.transfer(ms);
    exchange_due(engine, &mut server.clients);
    for i in 0..server.clients.len() {
        serve_client(engine, &mut server.clients, i);
    }
    for c in server.clients.iter_mut().filter(|c| c.gone) {
        leave(engine, c);
    }
    server.clients.retain(|c| !c.gone);
    engine.clients.client_target = clients_target(&server);
    engine.clients.server = Some(server);
}

/// Executes the requests of client `i` that have arrived, and answers it if its wait is over.
fn serve_client(engine: &mut Engine, clients: &mut [Client], i: usize) {
    for turn in 0..=MAX_IN_TURN {
        let Some(c) = clients.get_mut(i) else { return };
        // The condition that the last request waits for may already hold.
        settle(engine, c);
        let is_last = turn == MAX_IN_TURN;
        let Some(line) = (!is_last && c.is_served()).then(|| c.line()).flatten() else { break };
        let reply = match line {
            Ok(line) => respond(engine, clients, i, &line),
            Err(e) => Some(Err(e.into())),
        };
        if let (Some(reply), Some(c)) = (reply, clients.get_mut(i)) {
            c.answer(reply);
        }
    }
    if let Some(c) = clients.get_mut(i) {
        c.part();
    }
}
