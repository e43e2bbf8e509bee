//! Requests over HTTP that are refused by name.

use super::printer::Printer;
use hal_tests::web::{self, Socket};
use std::{fs, os::unix::fs::PermissionsExt as _};

/// Longest body of a request that is no upload, and one byte.
const TOO_LONG: usize = (64 << 10) + 1;

#[test]
fn a_request_that_is_not_right_is_refused_by_name() {
    let printer = Printer::start("viewer");
    let (host, port) = (printer.host(), printer.port);
    let used = printer.token();
    let session = printer.sign_in();
    let (good, other) = (session.headers(), printer.sign_in());
    let mode = fs::metadata(printer.scratch.path().join("address")).unwrap().permissions().mode();
    assert_eq!(mode & 0o777, 0o600);

    let cookie = format!("{host}Cookie: {}\r\n", session.cookie);
    let key = |key: &str| format!("{cookie}X-Ferrule-Key: {key}\r\n");
    let login = |token: &str| format!(r#"{{"token": "{token}"}}"#);
    let many = "pattern=a&".repeat(101);
    let (get, session_path) = ("GET", "/session");
    // Method, path, headers, body, status, code.
    let cases = [
        (get, "/info", good.clone(), String::new(), 200, ""),
        // Other servers and their pages.
        (
            get,
            "/info",
            good.replace("127.0.0.1", "evil.example"),
            String::new(),
            403,
            "foreign-origin",
        ),
        (get, "/info", good.replace("Host", "X-Host"), String::new(), 403, "foreign-origin"),
        (get, "/info", format!("{host}{good}"), String::new(), 403, "foreign-origin"),
        (
            get,
            "/info",
            format!("{good}Origin: http://evil.example\r\n"),
            String::new(),
            403,
            "foreign-origin",
        ),
        (get, "/info", format!("{good}Origin: null\r\n"), String::new(), 403, "foreign-origin"),
        (
            get,
            "/info",
            format!("{good}Origin: https://127.0.0.1:{port}\r\n"),
            String::new(),
            403,
            "foreign-origin",
        ),
        (
            get,
            "/info",
            format!("{good}Origin: http://127.0.0.1:{port}\r\n"),
            String::new(),
            200,
            "",
        ),
        (
            get,
            "/info",
            format!("{good}Sec-Fetch-Site: cross-site\r\nSec-Fetch-Mode: cors\r\n"),
            String::new(),
            403,
            "foreign-origin",
        ),
        (
            get,
            "/info",
            format!("{good}Sec-Fetch-Site: same-site\r\nSec-Fetch-Mode: no-cors\r\n"),
            String::new(),
            403,
            "foreign-origin",
        ),
        // Who has not signed in.
        (get, "/info", host.clone(), String::new(), 401, "no-session"),
        (get, "/info", cookie.clone(), String::new(), 401, "no-session"),
        (get, "/info", key(""), String::new(), 401, "no-session"),
        (get, "/info", key(&other.key), String::new(), 401, "no-session"),
        (get, "/info", good.replace("Cookie", "X-Cookie"), String::new(), 401, "no-session"),
        ("POST", session_path, host.clone(), login("00"), 401, "wrong-login"),
        ("POST", session_path, host.clone(), login(&used), 401, "wrong-login"),
        ("POST", session_path, host.clone(), login(""), 401, "wrong-login"),
        // What cannot be read.
        ("POST", session_path, host.clone(), String::new(), 400, "malformed"),
        ("POST", session_path, host.clone(), r#"{"token": 7}"#.to_owned(), 400, "malformed"),
        (
            "POST",
            session_path,
            host.clone(),
            r#"{"token": "a", "role": "integrator"}"#.to_owned(),
            400,
            "malformed",
        ),
        ("POST", session_path, host.clone(), "x".repeat(TOO_LONG), 413, "too-large"),
        (get, "/pins?name=a", good.clone(), String::new(), 400, "malformed"),
        (get, &format!("/pins?{many}"), good.clone(), String::new(), 413, "too-large"),
        (get, "/nothing", good.clone(), String::new(), 404, "not-found"),
        (get, "/nothing/at/all", good.clone(), String::new(), 404, "not-found"),
        ("PUT", "/info", good.clone(), String::new(), 405, "malformed"),
        (get, "/programs/none.ngc", good.clone(), String::new(), 404, "not-found"),
        (get, "/programs/none.ngc/path", good.clone(), String::new(), 404, "not-found"),
        (get, "/programs/..%2Fprinter.ini", good.clone(), String::new(), 400, "malformed"),
        (get, "/programs/.hidden", good.clone(), String::new(), 400, "malformed"),
        (get, "/programs/a%00b", good.clone(), String::new(), 400, "malformed"),
        // What the role may not do.
        ("PUT", "/programs/a.ngc", good.clone(), "M2\n".to_owned(), 403, "role"),
        ("DELETE", "/programs/a.ngc", good.clone(), String::new(), 403, "role"),
    ];
    for (method, path, headers, body, status, code) in &cases {
        let path = format!("/api/v1{path}");
        let answer = printer.request(method, &path, headers, body.as_bytes());
        let got = (answer.status, answer.code());
        let short: String = body.chars().take(80).collect();
        assert_eq!(got, (*status, (*code).to_owned()), "{method} {path} {headers} {short}");
    }
    assert!(printer.scratch.path().join("programs").read_dir().unwrap().next().is_none());

    // Bytes that are no request end the connection, and nothing else.
    for bytes in [&b"\0\0\0\0\r\n\r\n"[..], b"GET\r\n\r\n", &b"GET / HTTP/1.1\r\nX: ".repeat(4000)]
    {
        let answer = web::raw(port, bytes);
        assert!(!(200..300).contains(&answer.status), "{answer:?}");
    }

    // A session that has ended is one no more.
    let ended = printer.request("DELETE", "/api/v1/session", &other.headers(), b"");
    assert_eq!(ended.status, 200);
    let replayed = printer.request("GET", "/api/v1/info", &other.headers(), b"");
    assert_eq!((replayed.status, replayed.code()), (401, "no-session".to_owned()));
    let answer = printer.request("GET", "/api/v1/info", &good, b"");
    assert_eq!(answer.status, 200, "the other session lasts");
    for name in ["content-security-policy", "x-content-type-options", "cache-control"] {
        assert!(answer.header(name).is_some(), "{name}");
    }
}

#[test]
fn a_socket_of_another_page_is_refused() {
    let printer = Printer::start("operator");
    let session = printer.sign_in();
    let headers = format!("{}Cookie: {}\r\n", printer.host(), session.cookie);
    for foreign in ["Origin: http://evil.example\r\n", "Sec-Fetch-Site: cross-site\r\n"] {
        let answer = Socket::open(printer.port, "/api/v1/socket", &format!("{headers}{foreign}"))
            .unwrap_err();
        assert_eq!((answer.status, answer.code()), (403, "foreign-origin".to_owned()), "{foreign}");
    }
}

#[test]
fn a_program_is_stored_as_a_whole_or_not_at_all() {
    let printer = Printer::start("operator");
    let good = printer.sign_in().headers();
    let path = "/api/v1/programs/a.ngc";
    let stored = printer.request("PUT", path, &good, b"G0 X1\nM2\n");
    assert_eq!((stored.status, &stored.json()["bytes"]), (200, &9.into()), "{stored:?}");
    assert_eq!(printer.request("GET", path, &good, b"").body, b"G0 X1\nM2\n");
    // An upload that breaks off leaves the program as it was.
    let head =
        format!("PUT {path} HTTP/1.1\r\nConnection: close\r\n{good}Content-Length: 900\r\n\r\nM30");
    web::cut(printer.port, head.as_bytes());
    assert_eq!(printer.request("GET", path, &good, b"").body, b"G0 X1\nM2\n");
    let names = fs::read_dir(printer.scratch.path().join("programs/uploads")).unwrap();
    let names: Vec<_> = names.map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(names, ["a.ngc"]);
    assert_eq!(printer.request("DELETE", path, &good, b"").status, 200);
    assert_eq!(printer.request("GET", path, &good, b"").status, 404);
}
