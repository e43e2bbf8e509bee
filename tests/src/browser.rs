//! A browser that tests drive: Chromium without a screen, by the `WebDriver` protocol of its driver program.

use crate::{
    scratch::{Running, Scratch, try_until, until},
    tools::Tool,
    web,
};
use rustix::process::{Pid, Signal, kill_process};
use serde_json::{Value, json};
use std::{fs, process::Command};

/// Key of an element in answers of the driver.
const ELEMENT: &str = "element-6066-11e4-a52e-4f735466cecf";
/// Looks at a page after which its log is read.
const LOG: u32 = 100;
/// Chromium's arguments: no screen, and no traffic of its own.
const ARGUMENTS: &[&str] = &[
    "--headless=new",
    "--no-sandbox",
    "--disable-gpu",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-dev-shm-usage",
    "--lang=en",
];

/// Size of a window, and whether it is that of a phone.
#[derive(Clone, Copy, Debug)]
pub struct Screen {
    /// Width in pixels of the page.
    pub width: u32,
    /// Height in pixels of the page.
    pub height: u32,
    /// True for a screen that is touched, with two dots for each pixel.
    pub is_phone: bool,
}

/// A screen of a desk.
pub const DESKTOP: Screen = Screen { width: 1440, height: 1000, is_phone: false };
/// A screen of a pocket.
pub const PHONE: Screen = Screen { width: 390, height: 844, is_phone: true };

/// Starts the browser's driver. The port that it chooses may be taken by another program before it listens there; then it ends,
/// and another one is started.
fn driver(scratch: &Scratch) -> (Running, u16) {
    loop {
        let mut command = Command::new("chromedriver");
        command.arg("--port=0").current_dir(scratch.path());
        let mut driver = scratch.start(&mut command);
        let mut port = None;
        until("chromedriver says its port, or ends", || {
            port = driver.said().0.lines().find_map(|l| {
                let (_, rest) = l.split_once("successfully on port ")?;
                rest.trim_end_matches('.').parse().ok()
            });
            port.is_some() || !driver.is_running()
        });
        if let Some(port) = port {
            return (driver, port);
        }
        let (_, why) = driver.said();
        assert!(why.contains("Address already in use"), "chromedriver has ended: {why}");
    }
}

/// A window of the browser with one page.
#[derive(Debug)]
pub struct Browser {
    driver: Running,
    port: u16,
    session: String,
}

impl Browser {
    /// Returns whether Chromium and its driver are installed; reports the running test as skipped if not.
    pub fn is_there() -> bool {
        ["chromium", "chromedriver"].into_iter().all(|program| Tool::of(program).is_installed())
    }

    /// Opens a window.
    pub fn open(scratch: &Scratch, screen: Screen) -> Self {
        let (driver, port) = driver(scratch);
        let mut browser =
            Self { driver: driver.lasting("chromedriver"), port, session: String::new() };
        let profile = scratch.path().join(format!("profile-{}", browser.port));
        let mut arguments: Vec<_> = ARGUMENTS.iter().map(|&a| a.to_owned()).collect();
        arguments.push(format!("--user-data-dir={}", profile.display()));
        arguments.push(format!("--window-size={},{}", screen.width, screen.height));
        let mut options = json!({ "args": arguments });
        if screen.is_phone {
            options["mobileEmulation"] = json!({ "deviceMetrics": {
                "width": screen.width, "height": screen.height, "pixelRatio": 2, "touch": true } });
        }
        let capabilities = json!({ "capabilities": { "alwaysMatch": {
            "goog:chromeOptions": options, "goog:loggingPrefs": { "browser": "ALL" } } } });
        let made = browser.ask("POST", "/session", Some(&capabilities));
        browser.session = format!("/session/{}", made["sessionId"].as_str().unwrap());
        browser
    }

    /// Opens an address.
    pub fn go(&self, address: &str) {
        self.post("/url", &json!({ "url": address }));
    }

    /// Lets no request for these addresses succeed; `*` stands for any text.
    pub fn block(&self, addresses: &[&str]) {
        let command = |cmd: &str, params: Value| {
            self.post("/goog/cdp/execute", &json!({ "cmd": cmd, "params": params }));
        };
        command("Network.enable", json!({}));
        command("Network.setBlockedURLs", json!({ "urls": addresses }));
    }

    /// Returns the tab that is shown.
    pub fn tab(&self) -> String {
        let tab = self.ask("GET", &format!("{}/window", self.session), None);
        tab.as_str().unwrap().to_owned()
    }

    /// Opens an empty tab and shows it.
    pub fn new_tab(&self) -> String {
        let tab = self.post("/window/new", &json!({ "type": "tab" }));
        let tab = tab["handle"].as_str().unwrap().to_owned();
        self.to_tab(&tab);
        tab
    }

    /// Shows a tab.
    pub fn to_tab(&self, tab: &str) {
        self.post("/window", &json!({ "handle": tab }));
    }

    /// Closes the tab that is shown.
    pub fn close_tab(&self) {
        self.ask("DELETE", &format!("{}/window", self.session), None);
    }

    /// Kills the browser, with all processes that it has started.
    pub fn kill(&mut self) {
        let mut left = children(self.driver.pid());
        while let Some(pid) = left.pop() {
            left.extend(children(pid));
            if let Some(pid) = i32::try_from(pid).ok().and_then(Pid::from_raw) {
                // One that has ended meanwhile needs no signal.
                kill_process(pid, Signal::KILL).unwrap_or_default();
            }
        }
        self.session.clear();
    }

    /// Runs a script in the page; `return` gives its value.
    ///
    /// # Panics
    /// The script fails.
    pub fn run(&self, script: &str) -> Value {
        self.answer_of(script).unwrap_or_else(|why| panic!("{script}: {why}"))
    }

    /// Runs a script in the page; returns its value, or why it has none.
    fn answer_of(&self, script: &str) -> Result<Value, String> {
        let body = json!({ "script": script, "args": [] });
        self.answer("POST", &format!("{}/execute/sync", self.session), Some(&body))
    }

    /// Waits until an expression of the page is true.
    ///
    /// # Panics
    /// It never is, it cannot be evaluated, or a script of the page fails meanwhile.
    pub fn until(&self, expression: &str) {
        let script = format!("return Boolean({expression})");
        let mut looks = 0;
        let end = try_until(|| {
            looks += 1;
            match self.answer_of(&script) {
                Ok(Value::Bool(true)) => return true,
                Ok(_) => {}
                // A page that is loaded again meanwhile has no answer yet.
                Err(why) => assert!(why.contains("navigation"), "{expression}: {why}"),
            }
            if looks % LOG == 0 {
                assert_eq!(self.errors(), Vec::<String>::new(), "{expression}");
            }
            false
        });
        end.unwrap_or_else(|why| panic!("{expression}: {why}\n{}", self.shown()));
    }

    /// Returns what the page shows, for the report of a test that fails.
    fn shown(&self) -> String {
        let text = self
            .run("return `${location.href} ${document.readyState}\\n${document.body?.innerText}`");
        let log = self.post("/se/log", &json!({ "type": "browser" }));
        format!("the page: {}\nits log: {log}", text.as_str().unwrap_or_default())
    }

    /// Returns the text of the first element that the selector finds.
    pub fn text(&self, selector: &str) -> String {
        let script =
            format!("return document.querySelector({})?.textContent ?? ''", quoted(selector));
        self.run(&script).as_str().unwrap().to_owned()
    }

    /// Presses the first element that the selector finds for a while, with the mouse or a finger.
    pub fn hold(&self, selector: &str, milliseconds: u32) {
        self.press(selector);
        self.act(&[json!({ "type": "pause", "duration": milliseconds })]);
        self.release();
    }

    /// Releases what is pressed.
    pub fn release(&self) {
        self.act(&[json!({ "type": "pointerUp", "button": 0 })]);
    }

    /// Presses an element, and leaves it pressed.
    pub fn press(&self, selector: &str) {
        self.until(&format!(
            "document.querySelector({0}) && !document.querySelector({0}).disabled",
            quoted(selector)
        ));
        self.run(&format!(
            "document.querySelector({}).scrollIntoView({{ block: 'center' }})",
            quoted(selector)
        ));
        let element = self.element(selector);
        let to = json!({ "type": "pointerMove", "origin": { ELEMENT: element }, "x": 0, "y": 0, "duration": 0 });
        self.act(&[to, json!({ "type": "pointerDown", "button": 0 })]);
    }

    /// Presses an element for a moment.
    pub fn click(&self, selector: &str) {
        self.hold(selector, 20);
    }

    /// Types a text into an element; a file chooser takes paths.
    pub fn fill(&self, selector: &str, text: &str) {
        let element = self.element(selector);
        self.post(&format!("/element/{element}/value"), &json!({ "text": text }));
    }

    /// Presses or releases a key of the keyboard.
    pub fn key(&self, key: &str, is_down: bool) {
        let kind = if is_down { "keyDown" } else { "keyUp" };
        let keys =
            json!({ "type": "key", "id": "keys", "actions": [{ "type": kind, "value": key }] });
        self.post("/actions", &json!({ "actions": [keys] }));
    }

    /// Writes a picture of the page.
    pub fn picture(&self, path: &std::path::Path) {
        let picture = self.ask("GET", &format!("{}/screenshot", self.session), None);
        fs::write(path, unbase64(picture.as_str().unwrap())).unwrap();
    }

    /// Returns the errors of the page's scripts since the last call; refusals of the server are not among them.
    pub fn errors(&self) -> Vec<String> {
        let log = self.post("/se/log", &json!({ "type": "browser" }));
        let all = log.as_array().unwrap().iter();
        let severe = all.filter(|entry| entry["level"] == "SEVERE" && entry["source"] != "network");
        severe.map(|entry| entry["message"].as_str().unwrap().to_owned()).collect()
    }

    fn element(&self, selector: &str) -> String {
        let found = self.post("/element", &json!({ "using": "css selector", "value": selector }));
        found[ELEMENT].as_str().unwrap().to_owned()
    }

    fn act(&self, actions: &[Value]) {
        // The driver loses the end of a touch that is sent in another request. A phone's screen turns the mouse into touches.
        let pointer = json!({ "type": "pointer", "id": "pointer", "parameters": { "pointerType": "mouse" }, "actions": actions });
        self.post("/actions", &json!({ "actions": [pointer] }));
    }

    fn post(&self, path: &str, body: &Value) -> Value {
        self.ask("POST", &format!("{}{path}", self.session), Some(body))
    }

    /// Sends one request to the driver.
    ///
    /// # Panics
    /// The driver refuses it.
    fn ask(&self, method: &str, path: &str, body: Option<&Value>) -> Value {
        self.answer(method, path, body).unwrap_or_else(|why| panic!("{method} {path}: {why}"))
    }

    /// Sends one request to the driver; returns its answer or its refusal.
    fn answer(&self, method: &str, path: &str, body: Option<&Value>) -> Result<Value, String> {
        let body = body.map(Value::to_string).unwrap_or_default();
        let host = format!("Host: 127.0.0.1:{}\r\n", self.port);
        let answer = web::request(self.port, method, path, &host, body.as_bytes()).json();
        match answer.get("value") {
            None => Err("the driver does not answer".to_owned()),
            Some(value) if value["error"].is_null() => Ok(value.clone()),
            Some(value) => Err(value.to_string()),
        }
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // The driver ends the browser with the session; a test that failed may have lost it.
        let host = format!("Host: 127.0.0.1:{}\r\n", self.port);
        if self.driver.is_running() && !self.session.is_empty() {
            drop(web::request(self.port, "DELETE", &self.session, &host, b""));
        }
        if self.driver.is_running() {
            self.driver.signal(Signal::TERM);
        }
    }
}

/// Returns the processes that a process has started.
fn children(pid: u32) -> Vec<u32> {
    let Ok(tasks) = fs::read_dir(format!("/proc/{pid}/task")) else { return Vec::new() };
    let lists =
        tasks.filter_map(|task| fs::read_to_string(task.ok()?.path().join("children")).ok());
    let all = lists.collect::<Vec<_>>().join(" ");
    all.split_whitespace().filter_map(|pid| pid.parse().ok()).collect()
}

/// Returns a text as a string of a script.
fn quoted(text: &str) -> String {
    Value::from(text).to_string()
}

/// Decodes base64.
fn unbase64(text: &str) -> Vec<u8> {
    let value = |c: u8| match c {
        b'A'..=b'Z' => Some(c - b'A'),
        b'a'..=b'z' => Some(c - b'a' + 26),
        b'0'..=b'9' => Some(c - b'0' + 52),
        b'+' => Some(62),
        b'/' => Some(63),
        _ => None,
    };
    let (mut bits, mut count, mut out) = (0_u32, 0_u32, Vec::new());
    for digit in text.bytes().filter_map(value) {
        bits = bits << 6 | u32::from(digit);
        count += 6;
        if 8 <= count {
            count -= 8;
            out.push((bits >> count & 0xff).try_into().unwrap());
        }
    }
    out
}
