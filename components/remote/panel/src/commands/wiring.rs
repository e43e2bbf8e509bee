//! Changes of the wiring, as requests. The engine refuses those that lead to motion or to a line of the machine.

use super::Input;
use crate::error::Error;
use hal_protocol::Request;

pub(super) fn setp(given: &Input<'_>) -> Result<Vec<Request>, Error> {
    given.only(&["name", "value"])?;
    Ok(vec![Request::Set { name: given.needed("name")?, value: given.needed("value")? }])
}

pub(super) fn sets(given: &Input<'_>) -> Result<Vec<Request>, Error> {
    given.only(&["name", "value"])?;
    Ok(vec![Request::SetSignal { name: given.needed("name")?, value: given.needed("value")? }])
}

pub(super) fn net(given: &Input<'_>) -> Result<Vec<Request>, Error> {
    given.only(&["signal", "pins"])?;
    let pins = given.needed("pins")?.split_whitespace().map(str::to_owned).collect();
    Ok(vec![Request::Net { signal: given.needed("signal")?, pins }])
}

pub(super) fn linkp(given: &Input<'_>) -> Result<Vec<Request>, Error> {
    given.only(&["pin", "signal"])?;
    Ok(vec![Request::Link { pin: given.needed("pin")?, signal: given.needed("signal")? }])
}

pub(super) fn unlink(given: &Input<'_>) -> Result<Vec<Request>, Error> {
    given.only(&["pin"])?;
    Ok(vec![Request::Unlink { pin: given.needed("pin")? }])
}
