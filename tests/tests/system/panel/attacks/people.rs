//! Attacks by people who have signed in with few rights, and by pages of other servers in the browser of who has many.

use super::{
    super::{
        accounts::add,
        printer::{Printer, Session},
    },
    list::Tries,
};
use hal_tests::{
    scratch::until,
    web::{self, Answer, Socket},
};
use rustix::net::sockopt::set_socket_recv_buffer_size;
use serde_json::{Value, json};
use std::{fs, io::Write as _, net::TcpStream};

const NGC: &[u8] = b"G21\nM2\n";
/// More requests than there are seats for all people.
const MANY: usize = 80;

/// The printer with three people: an operator, a viewer and an integrator.
struct People {
    printer: Printer,
    tries: Tries,
}

fn key_of(answer: &Answer) -> (String, String) {
    let cookie = answer.header("set-cookie").unwrap().split_once(';').unwrap().0.to_owned();
    (cookie, answer.json()["key"].as_str().unwrap().to_owned())
}

impl People {
    fn start() -> Self {
        let mut printer = Printer::start("viewer");
        add(&printer, "ana=operator", "correct horse");
        add(&printer, "eva=viewer", "battery staple");
        add(&printer, "ivo=integrator", "staple correct");
        printer.scratch.write("programs/short.ngc", "G21\nG0 X10\nM2\n");
        printer.restart("viewer", &["--accounts", ".private/people"]);
        Self { printer, tries: Tries::default() }
    }

    /// Signs in; returns the answer.
    fn login(&self, body: &Value) -> Answer {
        let body = body.to_string();
        self.printer.request("POST", "/api/v1/session", &self.printer.host(), body.as_bytes())
    }

    fn sign_in(&self, user: &str, password: &str) -> Session {
        let answer = self.login(&json!({ "user": user, "password": password }));
        assert_eq!(answer.status, 200, "{answer:?}");
        let (cookie, key) = key_of(&answer);
        Session::of(self.printer.port, cookie, key)
    }

    fn request(&self, method: &str, path: &str, headers: &str, body: &[u8]) -> Answer {
        self.printer.request(method, &format!("/api/v1{path}"), headers, body)
    }

    /// Notes a request that has success if it is answered with 200.
    fn note(&mut self, attack: &str, answer: &Answer) {
        self.tries.note(
            attack,
            answer.status == 200,
            &format!("{} {}", answer.status, answer.code()),
        );
    }

    /// Notes a command that has success if it is not refused.
    fn order(&mut self, attack: &str, socket: &mut Socket, name: &str, args: &Value) {
        let code = socket.command(name, args);
        self.tries.note(attack, code.is_empty(), &code);
    }

    /// A person who has signed in takes seats for themselves alone.
    fn seats(&mut self, eva: &Session, ana: &Session) {
        // An answer that nobody reads keeps its seat: it is larger than what the system holds of it.
        self.printer.scratch.write("programs/large.ngc", "G0 X1\n".repeat(1_000_000));
        let path = "/api/v1/programs/large.ngc";
        let head = format!("GET {path} HTTP/1.1\r\n{}\r\n", eva.headers());
        let mut taken = Vec::new();
        for _ in 0..MANY {
            let mut stream = TcpStream::connect(("127.0.0.1", self.printer.port)).unwrap();
            set_socket_recv_buffer_size(&stream, 4 << 10).unwrap();
            stream.write_all(head.as_bytes()).unwrap();
            taken.push(stream);
        }
        until("the seats are taken", || {
            let path = "/programs/short.ngc/path";
            self.request("GET", path, &eva.headers(), b"").code() == "too-many"
        });
        let answer = self.request("GET", "/programs/short.ngc/path", &ana.headers(), b"");
        let said = format!("{} {}", answer.status, answer.code());
        let attack = "viewer: answers that nobody reads, on the seats of all";
        self.tries.note(attack, answer.status != 200, &said);
        drop(taken);
    }
}

fn lease(what: &str) -> Value {
    json!({ "type": "lease", "do": what })
}

#[test]
fn who_may_look_does_no_more() {
    let mut p = People::start();
    let (ana, eva) = (p.sign_in("ana", "correct horse"), p.sign_in("eva", "battery staple"));
    let (mut own, mut socket) = (ana.socket(), eva.socket());
    assert_eq!(p.request("PUT", "/programs/mine.ngc", &ana.headers(), NGC).status, 200);

    let answer = p.request("PUT", "/programs/theirs.ngc", &eva.headers(), NGC);
    p.note("viewer: PUT of a program", &answer);
    let answer = p.request("DELETE", "/programs/mine.ngc", &eva.headers(), b"");
    p.note("viewer: DELETE of an upload", &answer);
    let reply = socket.ask(lease("take"));
    p.tries.note("viewer: the lease", reply["ok"] == json!({}), &reply.to_string());
    socket.ask(lease("give"));
    assert_eq!(own.ask(lease("take"))["ok"], json!({}));
    socket.ask(lease("give"));
    let code = own.command("optional-stop", &json!({ "on": true }));
    p.tries.note("viewer: the end of an operator's lease", code == "lease", &code);
    own.ask(lease("take"));
    p.order("viewer: off without the role", &mut socket, "off", &json!({}));
    p.order("viewer: a pause of an operator's job", &mut socket, "pause", &json!({}));
    let set = json!({ "name": "stepgen.0.maxaccel", "value": "1" });
    let code = socket.command("setp", &set);
    p.tries.note("viewer: a value of the wiring", code != "role", &code);

    // Sessions of others.
    let stolen = ana.headers().replace(&ana.key, &eva.key);
    let answer = p.request("GET", "/session", &stolen, b"");
    p.note("viewer: an operator's cookie with a key of their own", &answer);
    let token = p.printer.token();
    let first = p.login(&json!({ "token": token, "attempt": "first" }));
    assert_eq!(first.status, 200, "{first:?}");
    let answer = p.login(&json!({ "token": token, "attempt": "another" }));
    p.note("viewer: the token that another has used", &answer);
    let (cookie, key) = key_of(&first);
    let ended = Session::of(p.printer.port, cookie, key);
    assert_eq!(p.request("DELETE", "/session", &ended.headers(), b"").status, 200);
    let answer = p.request("GET", "/info", &ended.headers(), b"");
    p.note("viewer: a session that has ended", &answer);
    p.seats(&eva, &ana);

    // Who may change the wiring moves nothing by it, least of all in e-stop.
    own.ask(lease("give"));
    let mut ivo = p.sign_in("ivo", "staple correct").socket();
    assert_eq!(ivo.ask(lease("take"))["ok"], json!({}));
    assert_eq!(ivo.command("estop", &json!({})), "");
    p.printer.halcmd("unlinkp stepgen.0.position-cmd");
    let set = json!({ "name": "stepgen.0.position-cmd", "value": "5" });
    p.order("integrator: the position of a drive in e-stop", &mut ivo, "setp", &set);
    p.tries.finish("panel::attacks::people::who_may_look_does_no_more");
}

#[test]
fn a_page_of_another_server_reaches_nothing() {
    let mut p = People::start();
    let ana = p.sign_in("ana", "correct horse");
    let (good, port) = (ana.headers(), p.printer.port);
    let host = p.printer.host();
    let cookie = format!("{host}Cookie: {}\r\n", ana.cookie);

    // Whatever a browser sends for the page of another server, with all that it has of the person.
    for (attack, headers) in [
        ("a request of another server's page", format!("{good}Origin: http://evil.example\r\n")),
        ("a request of a page without a server", format!("{good}Origin: null\r\n")),
        ("a request of another port's page", format!("{good}Origin: http://127.0.0.1:1\r\n")),
        ("a name of its own for this address", good.replace("127.0.0.1", "evil.example")),
        ("a second host beside the right one", format!("{good}Host: evil.example\r\n")),
        (
            "a picture that is a request",
            format!("{good}Sec-Fetch-Site: cross-site\r\nSec-Fetch-Mode: no-cors\r\n"),
        ),
        (
            "a script of another port's page",
            format!("{good}Sec-Fetch-Site: same-site\r\nSec-Fetch-Mode: cors\r\n"),
        ),
        ("a form without the key", cookie.clone()),
    ] {
        let answer = p.request("PUT", "/programs/a.ngc", &headers, NGC);
        p.note(&format!("web page: {attack}"), &answer);
    }
    let headers = format!("{cookie}Origin: http://evil.example\r\n");
    let opened = Socket::open(port, "/api/v1/socket", &headers);
    p.tries.note("web page: the socket from another server's page", opened.is_ok(), "");

    // What the answers permit.
    let page = web::request(port, "GET", "/", &host, b"");
    let policy = page.header("content-security-policy").unwrap_or_default().to_owned();
    let is_framed = !policy.contains("frame-ancestors 'none'");
    p.tries.note("web page: the panel in a frame", is_framed, &policy);
    let is_run = !policy.contains("script-src 'self';");
    p.tries.note("web page: a script in the panel's own page", is_run, &policy);
    let login = p.login(&json!({ "user": "ana", "password": "correct horse" }));
    let cookies = login.head.lines().filter(|line| line.starts_with("set-cookie: "));
    let is_read = cookies.clone().any(|line| !line.contains("; HttpOnly"));
    p.tries.note("web page: a script that reads the cookie", is_read, &login.head);
    let is_sent = cookies.clone().any(|line| !line.contains("; SameSite=Strict"));
    p.tries.note("web page: a cookie that goes along with its requests", is_sent, &login.head);
    fs::create_dir_all(p.printer.scratch.path().join("output")).unwrap();
    p.printer.scratch.write("output/evil.html", "<script>alert(1)</script>\n");
    let answer = p.request("GET", "/output/evil.html", &good, b"");
    assert_eq!(answer.status, 200);
    let is_shown = answer.header("content-disposition") != Some("attachment");
    p.tries.note("web page: a page that a program has written", is_shown, &answer.head);
    p.tries.finish("panel::attacks::people::a_page_of_another_server_reaches_nothing");
}
