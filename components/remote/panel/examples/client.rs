//! Prints how fast the machine moves, ten times: `client http://127.0.0.1:7776/#token=TOKEN`.
#![expect(clippy::print_stdout, reason = "a program")]

use serde::Deserialize;
use std::{
    env,
    error::Error,
    io::{Read as _, Write as _},
    net::TcpStream,
};
use tungstenite::{Message, client, client::IntoClientRequest as _};

#[derive(Deserialize)]
struct Session {
    user: String,
    key: String,
}
#[derive(Deserialize)]
struct Motion {
    time_ns: Option<i64>,
    velocity: Option<f64>,
}
#[derive(Deserialize)]
#[serde(tag = "type", rename_all = "lowercase")]
enum FromServer {
    Status {
        motion: Option<Motion>,
    },
    #[serde(other)]
    Other,
}

fn main() -> Result<(), Box<dyn Error>> {
    let address = env::args().nth(1).ok_or("the address with the token")?;
    let (host, token) =
        address.trim_start_matches("http://").split_once("/#token=").ok_or("no token")?;
    let body = format!("{{\"token\": \"{}\"}}", token.trim());
    let mut stream = TcpStream::connect(host)?;
    write!(
        stream,
        "POST /api/v1/session HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\nContent-Length: {}\r\n\r\n{body}",
        body.len()
    )?;
    let mut answer = String::new();
    stream.read_to_string(&mut answer)?;
    let (head, body) = answer.split_once("\r\n\r\n").ok_or("no answer")?;
    let session: Session = serde_json::from_str(body)?;
    let cookie =
        head.lines().find_map(|l| l.strip_prefix("set-cookie: ")).and_then(|l| l.split(';').next());
    let mut request = format!("ws://{host}/api/v1/socket").into_client_request()?;
    request.headers_mut().insert("cookie", cookie.ok_or("no cookie")?.parse()?);
    let (mut socket, _) = client(request, TcpStream::connect(host)?)?;
    socket.send(Message::text(format!("{{\"type\": \"hello\", \"key\": \"{}\"}}", session.key)))?;
    for _ in 0..10 {
        if let FromServer::Status { motion: Some(m) } =
            serde_json::from_str(socket.read()?.to_text()?)?
        {
            println!("{} at {:?} ns: {:?}", session.user, m.time_ns, m.velocity);
        }
    }
    Ok(())
}
