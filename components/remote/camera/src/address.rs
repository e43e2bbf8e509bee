//! Addresses of cameras.

use crate::Refused;

/// Longest address in bytes.
const MAX_LENGTH: usize = 2000;

/// Address `http://HOST[:PORT]/PATH`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Address {
    /// Host and port, as the request names them.
    pub host: String,
    /// Name or number of the host.
    pub name: String,
    /// Port.
    pub port: u16,
    /// Path with its query.
    pub path: String,
}

impl Address {
    /// Parses an address.
    ///
    /// # Errors
    /// It has another form, or characters that an address cannot have.
    pub fn parse(text: &str) -> Result<Self, Refused> {
        let rest = text.strip_prefix("http://").ok_or(Refused::Address)?;
        let is_clean = text.len() <= MAX_LENGTH && text.bytes().all(|b| b.is_ascii_graphic());
        let (host, path) = match rest.find('/') {
            Some(at) => rest.split_at_checked(at).ok_or(Refused::Address)?,
            None => (rest, "/"),
        };
        // An address of IPv6 is in brackets.
        let (name, port) = match host.strip_prefix('[') {
            Some(inner) => {
                let (name, rest) = inner.split_once(']').ok_or(Refused::Address)?;
                (name, rest.strip_prefix(':'))
            }
            None => match host.split_once(':') {
                Some((name, port)) => (name, Some(port)),
                None => (host, None),
            },
        };
        let port = port.map_or(Ok(80), |p| p.parse::<u16>().map_err(|_| Refused::Address))?;
        if !is_clean || name.is_empty() || host.contains('@') || port == 0 {
            return Err(Refused::Address);
        }
        Ok(Self { host: host.to_owned(), name: name.to_owned(), port, path: path.to_owned() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_have_one_form() {
        let address = Address::parse("http://192.0.2.7:8080/video?q=1").unwrap();
        assert_eq!((address.name.as_str(), address.port), ("192.0.2.7", 8080));
        assert_eq!(
            (address.host.as_str(), address.path.as_str()),
            ("192.0.2.7:8080", "/video?q=1")
        );
        assert_eq!(Address::parse("http://phone").unwrap().path, "/");
        assert_eq!(Address::parse("http://[::1]:81/x").unwrap().name, "::1");
        for bad in [
            "",
            "https://a/",
            "http://",
            "http:///x",
            "http://a:0/",
            "http://a:99999/",
            "http://a b/",
            "http://a/\r\nX: 1",
            "http://me@a/",
            "http://[::1/",
            "ftp://a/",
        ] {
            assert_eq!(Address::parse(bad), Err(Refused::Address), "{bad}");
        }
    }
}
