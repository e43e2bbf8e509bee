//! From nothing to a moving machine on a parallel port: the steps that a person takes, counted.

use super::printer::Session;
use hal_golden::check;
use hal_tests::{
    programs::root,
    scratch::{Scratch, until},
};
use rustix::process::Signal;
use serde_json::json;
use std::fs;

/// Most steps, of which the first puts the programs on the computer: the packages' own test shows that one.
const MOST: usize = 7;

/// Steps so far. One is a command typed, a file edited or a button pressed.
struct Steps(Vec<String>);

impl Steps {
    fn took(&mut self, step: &str) {
        self.0.push(step.to_owned());
    }
}

#[test]
fn seven_steps_and_a_file_of_answers_move_a_machine() {
    let scratch = Scratch::new("first-hour");
    let mut steps = Steps(vec!["install the package".to_owned()]);
    scratch.write("mill.setup", fs::read(root().join("tests/setup/mill.toml")).unwrap());

    steps.took("type: ferrule new mill.setup");
    let made = scratch.run(scratch.command(&[], "ferrule").args(["new", "mill.setup"]));
    assert_eq!((made.stderr.as_str(), made.status), ("", Some(0)));

    // Where there is a desktop, this opens the page as well.
    steps.took("type: ferrule start --virtual mill/mill.ini");
    let words = ["start", "--virtual", "--listen", "127.0.0.1:0", "--no-browser", "mill/mill.ini"];
    let started = scratch.start(scratch.command(&[], "ferrule").args(words));
    let mut started = started.lasting("ferrule");
    until("the panel", || started.said().0.contains("its address is in "));
    let (said, _) = started.said();
    let (_, file) = said.split_once("its address is in ").unwrap();
    let address = fs::read_to_string(file.lines().next().unwrap()).unwrap();
    let (place, token) = address.trim().split_once("/#token=").unwrap();
    let port = place.rsplit_once(':').unwrap().1.parse().unwrap();
    let mut page = Session::begin(port, token).socket();

    steps.took("press: Take control");
    assert_eq!(page.ask(json!({ "type": "lease", "do": "take" }))["ok"], json!({}));
    let places = || {
        ["stepgen.0.counts", "joint.0.pos-fb"]
            .map(|pin| scratch.told(&format!("getp {pin}")).trim().parse::<f64>().unwrap())
    };
    let before = places();
    for (button, name, args) in [
        ("Reset e-stop", "estop-reset", json!({})),
        ("On", "on", json!({})),
        ("Jog + of joint 0", "jog", json!({ "joint": 0, "velocity": 20, "distance": 5 })),
    ] {
        steps.took(&format!("press: {button}"));
        let reply = page.ask(json!({ "type": "command", "name": name, "args": args }));
        let done = if reply["pending"] == true {
            page.wait(|m| m["type"] == "done" && m["id"] == reply["id"]).unwrap()
        } else {
            reply
        };
        assert_eq!(done["error"], json!(null), "{name}: {done}");
    }
    until("steps at the motor of X", || places().iter().zip(before).all(|(now, was)| *now > was));
    started.signal(Signal::TERM);
    assert!(started.ended().is_some_and(|status| status.success()), "{:?}", started.said());

    assert!(steps.0.len() <= MOST, "{:?}", steps.0);
    let list: Vec<String> = (1..).zip(&steps.0).map(|(n, step)| format!("{n}. {step}\n")).collect();
    check(&root().join("tests/setup/first-hour.steps"), &list.concat());
}
