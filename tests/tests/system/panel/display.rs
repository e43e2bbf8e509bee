//! A machine whose user interface is the panel.

use hal_tests::{
    programs::root,
    scratch::{Scratch, until},
    web,
};
use std::fs;

#[test]
fn the_panel_is_the_display_of_a_machine() {
    let scratch = Scratch::copy_of(&root().join("configs/printer"));
    scratch.private("audit");
    let ini = scratch.read("printer.ini");
    let display =
        "DISPLAY = halpanel --listen 127.0.0.1:0 --address-file address --audit .private/audit";
    assert!(ini.contains("DISPLAY = axis"));
    scratch.write("printer.ini", ini.replace("DISPLAY = axis", display));
    let mut command = scratch.command(&[], "halrun");
    let mut machine = scratch.start(command.args(["--simulate", "printer.ini"]));
    let file = scratch.path().join("address");
    until("the panel writes its address", || {
        assert!(machine.is_running(), "{:?}", machine.said());
        fs::read_to_string(&file).is_ok_and(|text| text.contains("#token="))
    });
    let address = scratch.read("address");
    let (host, _) = address.strip_prefix("http://").unwrap().split_once('/').unwrap();
    let port = host.split_once(':').unwrap().1.parse().unwrap();
    let page = web::request(port, "GET", "/", &format!("Host: {host}\r\n"), b"");
    assert_eq!(page.status, 200, "{}", page.head);
    // The machine ends with its interface, and the address with it.
    let panel = scratch.halcmd(&["-s", "show", "comp", "halpanel"]);
    assert!(panel.stdout.contains("halpanel"), "{panel:?}");
    machine.signal(rustix::process::Signal::TERM);
    assert!(machine.ended().is_some(), "{:?}", machine.said());
    until("the panel ends", || !file.exists());
}
