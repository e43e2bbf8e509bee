//! TLS: the certificate, the machine's own or one that is made here, and its fingerprint.

use ring::digest::{SHA256, digest};
use std::{fs, io, os::unix::fs::PermissionsExt as _, path::Path, sync::Arc};
use tokio_rustls::{
    TlsAcceptor,
    rustls::{
        ServerConfig,
        crypto::ring::default_provider,
        pki_types::{CertificateDer, PrivateKeyDer, pem::PemObject as _},
        version::TLS13,
    },
};

/// TLS of the server.
pub(crate) struct Tls {
    pub(crate) acceptor: TlsAcceptor,
    /// SHA-256 of the certificate, for a person to compare.
    pub(crate) fingerprint: String,
}

/// Reads the certificate and its key, PEM in one file, or makes that file where there is none.
pub(crate) fn open(path: &Path, names: &[String]) -> Result<Tls, String> {
    let file = path.display();
    let fail = |e: io::Error| format!("{file}: {}", hal_output::reason(&e));
    if !path.exists() {
        hal_output::install(path, make(names)?.as_bytes(), 0o600).map_err(fail)?;
    }
    if fs::metadata(path).map_err(fail)?.permissions().mode() & 0o077 != 0 {
        return Err(format!(
            "{file}: it has a key, and others than its owner may use it: chmod 600"
        ));
    }
    let pem = fs::read(path).map_err(fail)?;
    read(&pem).map_err(|why| format!("{file}: {why}"))
}

fn make(names: &[String]) -> Result<String, String> {
    let fail = |e: rcgen::Error| format!("no certificate can be made: {e}");
    let made = rcgen::generate_simple_self_signed(names).map_err(fail)?;
    Ok(format!("{}{}", made.cert.pem(), made.signing_key.serialize_pem()))
}

fn read(pem: &[u8]) -> Result<Tls, String> {
    let chain: Result<Vec<_>, _> = CertificateDer::pem_slice_iter(pem).collect();
    let chain = chain.map_err(|e| format!("the certificate cannot be read: {e}"))?;
    let first = chain.first().ok_or("it has no certificate")?;
    let hex =
        digest(&SHA256, first).as_ref().iter().map(|b| format!("{b:02X}")).collect::<Vec<_>>();
    let fingerprint = hex.join(":");
    let key =
        PrivateKeyDer::from_pem_slice(pem).map_err(|e| format!("the key cannot be read: {e}"))?;
    let config = ServerConfig::builder_with_provider(Arc::new(default_provider()));
    let config = config.with_protocol_versions(&[&TLS13]).map_err(|e| e.to_string())?;
    let config = config.with_no_client_auth().with_single_cert(chain, key);
    let config = config.map_err(|e| format!("the certificate and the key do not fit: {e}"))?;
    Ok(Tls { acceptor: TlsAcceptor::from(Arc::new(config)), fingerprint })
}

#[cfg(test)]
mod tests {
    //! Files with certificates.

    use super::{make, open, read};
    use std::{fs, os::unix::fs::PermissionsExt as _};

    #[test]
    fn a_certificate_is_made_once_and_one_that_does_not_fit_is_refused() {
        let folder = std::env::temp_dir().join(format!("halpanel-tls-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let (file, names) = (folder.join("panel.pem"), ["machine.local".to_owned()]);
        let first = open(&file, &names).unwrap().fingerprint;
        assert_eq!(first.len(), 32 * 3 - 1);
        assert_eq!(open(&file, &names).unwrap().fingerprint, first, "it is kept");
        fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
        assert!(open(&file, &names).err().unwrap().contains("chmod 600"));

        let (own, other) = (make(&names).unwrap(), make(&names).unwrap());
        let key = |pem: &str| pem[pem.find("-----BEGIN PRIVATE").unwrap()..].to_owned();
        let cert = |pem: &str| pem[..pem.find("-----BEGIN PRIVATE").unwrap()].to_owned();
        for (pem, why) in [
            (cert(&own) + &key(&other), "the certificate and the key do not fit"),
            (cert(&own), "the key cannot be read"),
            (key(&own), "it has no certificate"),
            (own.replace("MII", "!!!"), "the certificate cannot be read"),
            (String::new(), "it has no certificate"),
        ] {
            let said = read(pem.as_bytes()).err().unwrap();
            assert!(said.starts_with(why), "{said}");
        }
        fs::remove_dir_all(&folder).unwrap();
    }
}
