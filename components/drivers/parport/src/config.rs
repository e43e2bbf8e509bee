//! Parser of `cfg=`: the ports, and the direction of their lines.

use hal_component::Error;

/// Maximum number of ports per load.
pub(crate) const MAX_PORTS: usize = 8;

/// Configuration of one port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PortConfig {
    pub(crate) place: PortLocation,
    pub(crate) mode: Mode,
}

/// Location of a port.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PortLocation {
    /// Address of its data register.
    Address(u16),
    /// Number of the port in the kernel: 0 for `/dev/parport0`.
    Kernel(u8),
}

/// Direction of a port's lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mode {
    /// Data and control lines are outputs.
    Out,
    /// Data lines are inputs, control lines outputs.
    In,
    /// Data lines are outputs, control lines inputs.
    X,
    /// Same as [`Mode::Out`], on a chip in EPP mode.
    Epp,
}

impl Mode {
    fn parse(word: &str) -> Option<Self> {
        match word.bytes().next()? {
            b'o' => Some(Self::Out),
            b'i' => Some(Self::In),
            b'x' => Some(Self::X),
            b'e' => Some(Self::Epp),
            _ => None,
        }
    }

    /// Returns whether the data lines are inputs.
    pub(crate) fn reads_data(self) -> bool {
        self == Self::In
    }

    /// Returns whether the control lines are inputs.
    pub(crate) fn reads_control(self) -> bool {
        self == Self::X
    }
}

impl PortLocation {
    fn parse(word: &str) -> Option<Self> {
        let digits = word.strip_prefix("0x").or_else(|| word.strip_prefix("0X")).unwrap_or(word);
        if !digits.bytes().all(|c| c.is_ascii_hexdigit()) {
            return None;
        }
        let address = u16::from_str_radix(digits, 16).ok()?;
        match u8::try_from(address) {
            Ok(number) if number < 16 => Some(Self::Kernel(number)),
            // The last register of the port must have a valid address as well.
            _ => address.checked_add(2).map(|_| Self::Address(address)),
        }
    }
}

/// Parses `ADDR [mode] [ADDR [mode] …]`.
pub(crate) fn parse(cfg: Option<&str>) -> Result<Vec<PortConfig>, Error> {
    let Some(cfg) = cfg else { return Err(refused("no config string", FORM)) };
    let mut ports: Vec<PortConfig> = Vec::new();
    let split = |c: char| c.is_whitespace() || c == '_';
    let mut words = cfg.split(split).filter(|w| !w.is_empty()).peekable();
    while let Some(word) = words.next() {
        let bad = |why| Err(refused(&format!("bad port address '{word}'"), why));
        let Some(place) = PortLocation::parse(word) else { return bad(ADDRESS) };
        if ports.iter().any(|p| p.place == place) {
            return bad("it is there already");
        }
        if ports.len() == MAX_PORTS {
            return bad("there is room for 8 ports");
        }
        let mode = words.peek().and_then(|w| Mode::parse(w));
        if mode.is_some() {
            words.next();
        }
        ports.push(PortConfig { place, mode: mode.unwrap_or(Mode::Out) });
    }
    if ports.is_empty() {
        return Err(refused("no ports configured", FORM));
    }
    Ok(ports)
}

const FORM: &str = "give cfg=\"ADDR [out|in|x|epp] …\", such as cfg=\"0x378 out\"";
const ADDRESS: &str = "expected a hexadecimal address (0x10 to 0xfffd) or a port's number in the kernel (0 to f), \
     each followed by out, in, x, epp or nothing";

fn refused(what: &str, why: &str) -> Error {
    Error::new(format!("PARPORT: ERROR: {what}: {why}"))
}

#[cfg(test)]
mod tests {
    use super::{Mode, PortConfig, PortLocation, parse};

    fn at(address: u16, mode: Mode) -> PortConfig {
        PortConfig { place: PortLocation::Address(address), mode }
    }

    #[test]
    fn good_strings() {
        for (cfg, ports) in [
            ("0x378", vec![at(0x378, Mode::Out)]),
            ("378", vec![at(0x378, Mode::Out)]),
            ("0X3BC_in", vec![at(0x3BC, Mode::In)]),
            (" 0x378\tout\n0x278  in ", vec![at(0x378, Mode::Out), at(0x278, Mode::In)]),
            ("0x378 0x278 x", vec![at(0x378, Mode::Out), at(0x278, Mode::X)]),
            ("d010 epp", vec![at(0xD010, Mode::Epp)]),
            ("10 o fffd i", vec![at(0x10, Mode::Out), at(0xFFFD, Mode::In)]),
            ("0 in", vec![PortConfig { place: PortLocation::Kernel(0), mode: Mode::In }]),
            ("0xF", vec![PortConfig { place: PortLocation::Kernel(15), mode: Mode::Out }]),
        ] {
            assert_eq!(parse(Some(cfg)), Ok(ports), "{cfg:?}");
        }
        let most = "100 200 300 400 500 600 700 800";
        assert_eq!(parse(Some(most)).map(|p| p.len()), Ok(8));
    }

    #[test]
    fn bad_strings() {
        let address = |word| format!("bad port address '{word}'");
        for (cfg, says) in [
            (None, "no config string".to_owned()),
            (Some(""), "no ports configured".to_owned()),
            (Some(" _ "), "no ports configured".to_owned()),
            (Some("zz"), address("zz")),
            (Some("out"), address("out")),
            (Some("0x378 q"), address("q")),
            (Some("0x378 out in"), address("in")),
            (Some("0x378 Out"), address("Out")),
            (Some("0x"), address("0x")),
            (Some("-378"), address("-378")),
            (Some("+378"), address("+378")),
            (Some("0xfffe"), address("0xfffe")),
            (Some("10000"), address("10000")),
            (Some("0x378 in 378"), address("378")),
            (Some("100 200 300 400 500 600 700 800 900"), address("900")),
        ] {
            let text = parse(cfg).unwrap_err().text().unwrap_or_default().to_owned();
            let wanted = format!("PARPORT: ERROR: {says}: ");
            assert!(text.starts_with(&wanted), "{cfg:?}: {text}");
        }
    }
}
