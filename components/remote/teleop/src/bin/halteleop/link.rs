//! The connection: plain on this computer, elsewhere inside TLS with the certificate of this fingerprint.

use crate::{
    Failure,
    options::{Options, Status},
};
use ring::digest::{SHA256, digest};
use rustls::{
    ClientConfig, ClientConnection, DigitallySignedStruct, Error, SignatureScheme, StreamOwned,
    client::danger::{HandshakeSignatureValid, ServerCertVerified, ServerCertVerifier},
    crypto::{CryptoProvider, ring::default_provider, verify_tls13_signature},
    pki_types::{CertificateDer, ServerName, UnixTime},
    version::TLS13,
};
use std::{
    io::{ErrorKind, Read, Write},
    net::TcpStream,
    sync::Arc,
    time::Duration,
};

/// Longest time for a connection, and for the beginning of TLS.
const CONNECT: Duration = Duration::from_secs(10);
/// Longest wait for bytes.
const TICK: Duration = Duration::from_millis(20);

/// A connection.
#[derive(Debug)]
pub(crate) struct Link {
    stream: Stream,
    is_closed: bool,
}

#[derive(Debug)]
enum Stream {
    Plain(TcpStream),
    Encrypted(Box<StreamOwned<ClientConnection, TcpStream>>),
}

impl Link {
    /// Connects.
    pub(crate) fn open(options: &Options) -> Result<Self, Failure> {
        let address = options.address()?;
        let pinned = options.pinned()?;
        if pinned.is_none() && !address.ip().is_loopback() {
            let text = format!(
                "{}: a network address needs --fingerprint, which halpanel prints at the machine",
                options.to
            );
            return Err((Status::Local, text));
        }
        let why = |e: &std::io::Error| {
            (Status::Lost, format!("{}: no connection: {}", options.to, hal_output::reason(e)))
        };
        let stream = TcpStream::connect_timeout(&address, CONNECT).map_err(|e| why(&e))?;
        let begin = |stream: &TcpStream| {
            stream.set_nodelay(true)?;
            stream.set_write_timeout(Some(CONNECT))?;
            stream.set_read_timeout(Some(CONNECT))
        };
        begin(&stream).map_err(|e| why(&e))?;
        let stream = match pinned {
            None => Stream::Plain(stream),
            Some(fingerprint) => {
                let text = |e: String| (Status::Lost, format!("{}: no TLS: {e}", options.to));
                let config = config(fingerprint).map_err(|e| text(e.to_string()))?;
                let name = ServerName::IpAddress(address.ip().into());
                let mut client = ClientConnection::new(Arc::new(config), name)
                    .map_err(|e| text(e.to_string()))?;
                let mut stream = stream;
                while client.is_handshaking() {
                    client.complete_io(&mut stream).map_err(|e| text(e.to_string()))?;
                }
                Stream::Encrypted(Box::new(StreamOwned::new(client, stream)))
            }
        };
        let socket = match &stream {
            Stream::Plain(stream) => stream,
            Stream::Encrypted(stream) => &stream.sock,
        };
        socket.set_read_timeout(Some(TICK)).map_err(|e| why(&e))?;
        Ok(Self { stream, is_closed: false })
    }

    /// Sends bytes; returns false if the connection has ended.
    pub(crate) fn send(&mut self, bytes: &[u8]) -> bool {
        let sent = match &mut self.stream {
            Stream::Plain(stream) => stream.write_all(bytes),
            Stream::Encrypted(stream) => stream.write_all(bytes).and_then(|()| stream.flush()),
        };
        self.is_closed |= sent.is_err();
        !self.is_closed
    }

    /// Returns the bytes that have arrived within a short time; `None` once the connection has ended.
    pub(crate) fn receive(&mut self) -> Option<Vec<u8>> {
        let mut buffer = [0; 4096];
        let read = match &mut self.stream {
            Stream::Plain(stream) => stream.read(&mut buffer),
            Stream::Encrypted(stream) => stream.read(&mut buffer),
        };
        let pause = [ErrorKind::WouldBlock, ErrorKind::TimedOut, ErrorKind::Interrupted];
        match read {
            Ok(count) if count > 0 => Some(buffer.get(..count).unwrap_or_default().to_vec()),
            Err(e) if pause.contains(&e.kind()) => Some(Vec::new()),
            Ok(_) | Err(_) => {
                self.is_closed = true;
                None
            }
        }
    }

    /// Returns whether the connection has ended.
    pub(crate) const fn is_closed(&self) -> bool {
        self.is_closed
    }
}

fn config(fingerprint: Vec<u8>) -> Result<ClientConfig, Error> {
    let provider = Arc::new(default_provider());
    let verifier = Pinned { fingerprint, provider: provider.clone() };
    let config = ClientConfig::builder_with_provider(provider).with_protocol_versions(&[&TLS13])?;
    let config = config.dangerous().with_custom_certificate_verifier(Arc::new(verifier));
    Ok(config.with_no_client_auth())
}

/// Trusts the certificate of one fingerprint, which a person has compared, and no other.
#[derive(Debug)]
struct Pinned {
    fingerprint: Vec<u8>,
    provider: Arc<CryptoProvider>,
}

impl ServerCertVerifier for Pinned {
    fn verify_server_cert(
        &self,
        certificate: &CertificateDer<'_>,
        _: &[CertificateDer<'_>],
        _: &ServerName<'_>,
        _: &[u8],
        _: UnixTime,
    ) -> Result<ServerCertVerified, Error> {
        let own = digest(&SHA256, certificate);
        if own.as_ref() == self.fingerprint {
            return Ok(ServerCertVerified::assertion());
        }
        let hex: Vec<String> = own.as_ref().iter().map(|byte| format!("{byte:02X}")).collect();
        let text = format!("the certificate has another fingerprint, {}", hex.join(":"));
        Err(Error::General(text))
    }

    fn verify_tls12_signature(
        &self,
        _: &[u8],
        _: &CertificateDer<'_>,
        _: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, Error> {
        Err(Error::General("TLS 1.3 is needed".to_owned()))
    }

    fn verify_tls13_signature(
        &self,
        message: &[u8],
        certificate: &CertificateDer<'_>,
        signature: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, Error> {
        let algorithms = &self.provider.signature_verification_algorithms;
        verify_tls13_signature(message, certificate, signature, algorithms)
    }

    fn supported_verify_schemes(&self) -> Vec<SignatureScheme> {
        self.provider.signature_verification_algorithms.supported_schemes()
    }
}
