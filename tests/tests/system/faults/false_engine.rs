//! An engine and its clients trust only objects that their own user can have created: the folder, the lock, the socket,
//! and the process at the other end. Needs root, which can act as several users.
#![expect(clippy::unwrap_used, reason = "tests")]

use hal_engine::{ClockKind, Engine};
use hal_protocol::{
    Client, Direction, Folder, NOT_RUNNING, Place, Reply, Request, Type, WireReply, WireRequest,
};
use hal_tests::{
    machine::{Served, options, status},
    programs::programs,
    raw::Raw,
    scratch::{Running, Scratch, until},
    user::{ROOT, as_user, is_root},
};
use rustix::fs::{CWD, FileType, Mode, mknodat};
use std::{
    fs::{self, File},
    io::{BufRead, BufReader, Write},
    os::unix::{
        fs::{MetadataExt, PermissionsExt, chown, symlink},
        net::{UnixListener, UnixStream},
        process::CommandExt,
    },
    path::{Path, PathBuf},
};

const USER: u32 = 60_001;
const OTHER: u32 = 60_002;

/// Creates a folder for temporary files: everyone may create files in it, and only their owners may remove them.
fn temporary(name: &str) -> (Scratch, PathBuf) {
    let scratch = Scratch::new(name);
    let tmp = scratch.path().join("tmp");
    fs::create_dir(&tmp).unwrap();
    mode(&tmp, 0o1777);
    (scratch, tmp)
}

fn mode(path: &Path, mode: u32) {
    fs::set_permissions(path, fs::Permissions::from_mode(mode)).unwrap();
}

/// Creates the folder of a user's instances as that user would.
fn folder_of(user: u32, folder: &Path) {
    as_user(user, || fs::create_dir(folder)).unwrap();
    mode(folder, 0o700);
}

/// Listens at a socket as a user, like an engine; it does not answer.
fn listen(user: u32, socket: &Path) -> UnixListener {
    let listener = as_user(user, || UnixListener::bind(socket)).unwrap();
    listener.set_nonblocking(true).unwrap();
    mode(socket, 0o777);
    listener
}

/// Returns the reason why a user does not connect; empty if the connection succeeds.
fn refusal(user: u32, place: &Place) -> String {
    as_user(user, || match Folder::open(place) {
        Ok(folder) => match folder.connect(place) {
            Ok(Some(_)) => String::new(),
            Ok(None) => "nobody listens".to_owned(),
            Err(e) => hal_protocol::Failure::from(e).to_string(),
        },
        Err(e) => hal_protocol::Failure::from(e).to_string(),
    })
}

#[test]
fn a_client_passes_by_what_another_user_has_made() {
    if !is_root() {
        return;
    }
    let (_scratch, tmp) = temporary("client");
    let at = |name: &str| {
        let folder = tmp.join(name);
        (Place::at(&folder, "default").unwrap(), folder)
    };
    let own = "name a folder of this user's own in HAL_RUNTIME_DIR";
    let shown = |path: &Path| path.display().to_string();

    // No folder, then one that another user created first.
    let (place, folder) = at("first");
    assert_eq!(refusal(USER, &place), format!("{}: there is no such folder", shown(&folder)));
    folder_of(OTHER, &folder);
    mode(&folder, 0o777);
    let theirs = listen(OTHER, &place.socket());
    let want = format!("{} belongs to user {OTHER}, not to user {USER}; {own}", shown(&folder));
    assert_eq!(refusal(USER, &place), want);
    let failure = as_user(USER, || Client::connect(&place, "").unwrap_err());
    assert_eq!((failure.code, failure.to_string()), (-13, want));
    assert!(theirs.accept().is_err(), "nobody has connected");

    // A symbolic link, also to a folder that would be correct.
    let (place, folder) = at("link");
    let (_, right) = at("right");
    folder_of(USER, &right);
    as_user(OTHER, || symlink(&right, &folder)).unwrap();
    let want =
        format!("{} is a symbolic link, which leads anywhere; remove it, or {own}", shown(&folder));
    assert_eq!(refusal(USER, &place), want);
    // A file instead of a folder.
    let (place, folder) = at("file");
    as_user(USER, || File::create(&folder)).unwrap();
    let want = format!("{} is not a folder; remove it, or {own}", shown(&folder));
    assert_eq!(refusal(USER, &place), want);

    // Modes: other users may read the folder, but not write to it.
    let (place, folder) = at("modes");
    folder_of(USER, &folder);
    let ours = listen(USER, &place.socket());
    for bits in [0o700, 0o711, 0o755] {
        mode(&folder, bits);
        assert_eq!(refusal(USER, &place), "");
    }
    for bits in [0o720, 0o702, 0o777, 0o1777, 0o2770] {
        mode(&folder, bits);
        let path = shown(&folder);
        let want = format!(
            "{path} can be written by other users (mode {bits:04o}); run 'chmod go-w {path}', or {own}"
        );
        assert_eq!(refusal(USER, &place), want);
    }
    drop(ours);
    mode(&folder, 0o700);
    assert_eq!(refusal(USER, &place), "nobody listens");

    // Files that another user left in it while that was possible.
    fs::remove_file(place.socket()).unwrap();
    mode(&folder, 0o777);
    let theirs = listen(OTHER, &place.socket());
    mode(&folder, 0o700);
    let socket = shown(&place.socket());
    let want = format!("{socket} belongs to user {OTHER}, not to user {USER}; {own}");
    assert_eq!(refusal(USER, &place), want);
    // The file is correct, but another user listens.
    chown(place.socket(), Some(USER), None).unwrap();
    let want = format!("the engine at {socket} runs as user {OTHER}, not as user {USER}");
    assert_eq!(refusal(USER, &place), want);
    drop(theirs);
    fs::remove_file(place.socket()).unwrap();
    symlink(tmp.join("first/default.sock"), place.socket()).unwrap();
    let want = format!("{socket} is a symbolic link, which leads anywhere; remove it, or {own}");
    assert_eq!(refusal(USER, &place), want);
    fs::remove_file(place.socket()).unwrap();
    File::create(place.socket()).unwrap();
    assert_eq!(refusal(USER, &place), format!("{socket} is not a socket; remove it, or {own}"));
}

#[test]
fn a_folder_that_is_exchanged_after_it_was_checked_is_not_used() {
    if !is_root() {
        return;
    }
    let (_scratch, tmp) = temporary("exchanged");
    let folder = tmp.join("folder");
    folder_of(USER, &folder);
    let place = Place::at(&folder, "default").unwrap();
    let ours = listen(USER, &place.socket());
    let checked = as_user(USER, || Folder::open(&place)).unwrap();
    fs::rename(&folder, tmp.join("away")).unwrap();
    folder_of(OTHER, &folder);
    mode(&folder, 0o777);
    let theirs = listen(OTHER, &place.socket());
    let socket = as_user(USER, || checked.connect(&place)).unwrap();
    assert!(socket.is_some() && ours.accept().is_ok() && theirs.accept().is_err());
    // The files that an engine creates and removes do not go there either.
    fs::remove_file(tmp.join("away/default.sock")).unwrap();
    let lock = as_user(USER, || checked.lock(&place)).unwrap();
    let listener = as_user(USER, || checked.listen(&place)).unwrap();
    let names = |folder: &str| {
        let names = fs::read_dir(tmp.join(folder)).unwrap().map(|e| e.unwrap().file_name());
        let mut names: Vec<_> = names.map(|n| n.into_string().unwrap()).collect();
        names.sort();
        names
    };
    assert_eq!(names("away"), ["default.lock", "default.sock"]);
    checked.remove(&place);
    drop((lock, listener));
    assert_eq!((names("away"), names("folder")), (vec![], vec!["default.sock".to_owned()]));
}

#[test]
fn an_engine_is_not_made_where_another_user_could_be_in_its_place() {
    if !is_root() {
        return;
    }
    let (_scratch, tmp) = temporary("engine");
    let made = |place: &Place| {
        let engine = Engine::new(options(place.clone(), ClockKind::Virtual));
        engine.map(Engine::close).map_err(|e| e.to_string())
    };
    let own = "name a folder of this user's own in HAL_RUNTIME_DIR";
    let folder = tmp.join("theirs");
    folder_of(OTHER, &folder);
    let place = Place::at(&folder, "default").unwrap();
    let path = folder.display();
    let want = format!("{path} belongs to user {OTHER}, not to user {ROOT}; {own}");
    assert_eq!(made(&place), Err(want), "not even root, and not even where it was named");
    let folder = tmp.join("ours");
    let place = Place::at(&folder, "default").unwrap();
    assert_eq!(made(&place), Ok(()));
    assert_eq!(fs::metadata(&folder).unwrap().mode() & 0o7777, 0o700);
    mode(&folder, 0o730);
    let said = made(&place).unwrap_err();
    assert!(said.contains("can be written by other users (mode 0730)"), "{said}");
    mode(&folder, 0o700);

    // The lock: nothing that could hang, lead elsewhere, or be held by another user.
    let lock = place.lock();
    let shown = lock.display();
    mknodat(CWD, &lock, FileType::Fifo, Mode::from_raw_mode(0o600), 0).unwrap();
    assert_eq!(made(&place), Err(format!("{shown}: it is not a regular file")));
    assert!(Folder::open(&place).unwrap().is_free(&place), "looking does not hang either");
    fs::remove_file(&lock).unwrap();
    symlink(tmp.join("elsewhere"), &lock).unwrap();
    let said = made(&place).unwrap_err();
    assert!(said.starts_with(&format!("{shown}: ")) && !tmp.join("elsewhere").exists(), "{said}");
    fs::remove_file(&lock).unwrap();
    File::create(&lock).unwrap();
    chown(&lock, Some(OTHER), None).unwrap();
    let want = format!("{shown} belongs to user {OTHER}, not to user {ROOT}; {own}");
    assert_eq!(made(&place), Err(want));
    fs::remove_file(&lock).unwrap();
    // At its socket's path, an engine removes only what it may remove: not a folder.
    fs::create_dir(place.socket()).unwrap();
    let said = made(&place).unwrap_err();
    assert_eq!(said, format!("{}: Is a directory", place.socket().display()));
    fs::remove_dir(place.socket()).unwrap();
    assert_eq!(made(&place), Ok(()));
}

#[test]
fn an_engine_serves_its_own_user_and_root() {
    if !is_root() {
        return;
    }
    let scratch = Scratch::new("served");
    let served = Served::on(ClockKind::Virtual, &scratch, "served", "loadrt threads");
    let socket = served.place.socket();
    assert_eq!(fs::metadata(&socket).unwrap().mode() & 0o7777, 0o600);
    // As after a mistake of the administrator.
    mode(served.place.folder(), 0o755);
    mode(&socket, 0o777);
    let mut raw = as_user(USER, || Raw::connect(&served));
    let want = format!(
        "this instance belongs to user {ROOT}, and is used by that user and root; this program \
         runs as user {USER}"
    );
    let answer = raw.answer();
    match serde_json::from_str(&answer) {
        Ok(WireReply::Error(failure)) => assert_eq!(failure.text, want),
        other => unreachable!("{other:?}"),
    }
    assert_eq!(raw.answer(), "", "and hung up");
    // The client does not even send a request.
    let said = as_user(USER, || Client::connect(&served.place, "").unwrap_err().to_string());
    assert!(said.contains(&format!("belongs to user {ROOT}, not to user {USER}")), "{said}");
    assert_eq!(status(&mut served.client()).instance, "served");
    served.end();
}

#[test]
fn root_uses_an_instance_of_a_user_that_it_names() {
    if !is_root() {
        return;
    }
    let (scratch, tmp) = temporary("named");
    let folder = tmp.join("ferrule");
    folder_of(USER, &folder);
    let place = Place::at(&folder, "default").unwrap();
    let ours = listen(USER, &place.socket());
    assert_eq!(refusal(ROOT, &place), "");
    assert!(ours.accept().is_ok());
    // A folder that the system provides, such as XDG_RUNTIME_DIR, is not named.
    mode(&tmp, 0o755);
    let mut halcmd = scratch.command(&[], "halcmd");
    halcmd.env_remove("HAL_RUNTIME_DIR").env("XDG_RUNTIME_DIR", &tmp);
    let output = scratch.run(halcmd.args(["show", "pin"]));
    let want = format!("{} belongs to user {USER}, not to user {ROOT}", folder.display());
    assert!(output.stderr.contains(&want), "{}", output.stderr);
    assert_eq!(output.status, Some(1));
    assert!(ours.accept().is_err());
    // After another user takes its socket over, the socket is not that user's.
    drop(ours);
    fs::remove_file(place.socket()).unwrap();
    mode(&folder, 0o777);
    let theirs = listen(OTHER, &place.socket());
    mode(&folder, 0o700);
    let want = format!("belongs to user {OTHER}, not to user {USER}");
    assert!(refusal(ROOT, &place).contains(&want));
    drop(theirs);
}

/// Answers every request like an engine in which every pin is true, until a client sends `end`; returns the number of
/// earlier clients.
fn impersonate(listener: &UnixListener) -> usize {
    listener.set_nonblocking(false).unwrap();
    for served in 0.. {
        let (socket, _) = listener.accept().unwrap();
        let mut writer = socket.try_clone().unwrap();
        for line in BufReader::new(socket).lines().map_while(Result::ok) {
            let reply = if line == "end" {
                return served;
            } else if line.contains("hello") {
                let (instance, version) = ("default".to_owned(), "0".to_owned());
                Reply::Hello { protocol: 1, instance, version, id: 1 }
            } else {
                Reply::Value(hal_protocol::Value::Bit(true))
            };
            let line = serde_json::to_string(&WireReply::Ok(reply)).unwrap();
            if writeln!(writer, "{line}").is_err() {
                break;
            }
        }
    }
    unreachable!()
}

/// The programs, run by a user without a folder provided by the system, while another user impersonates the engine.
#[test]
fn programs_refuse_a_false_engine_with_a_status() {
    if !is_root() {
        return;
    }
    let reachable = std::process::Command::new(programs().join("halcmd")).uid(USER).output();
    if reachable.is_err() {
        return hal_tests::tools::report("another user cannot run the programs under test");
    }
    let (scratch, tmp) = temporary("programs");
    let place = Place::at(tmp.join(format!("ferrule-{USER}")), "default").unwrap();
    let machine = tmp.join("machine.hal");
    fs::write(&machine, "loadrt threads name1=t period1=1000000\nstart\n").unwrap();
    let start = |program: &str, words: &[&str]| -> Running {
        let mut command = scratch.command(&[], program);
        command.env_remove("HAL_RUNTIME_DIR").env_remove("XDG_RUNTIME_DIR").env("TMPDIR", &tmp);
        scratch.start(command.uid(USER).gid(USER).current_dir(&tmp).args(words))
    };
    let run = |program: &str, words: &[&str]| start(program, words).wait();
    // First without an engine, then with the user's own engine: the programs work, and leave nothing.
    let output = run("halcmd", &["show", "pin"]);
    assert!(output.stderr.contains("no instance 'default' is running"), "{}", output.stderr);
    assert_eq!(run("halrun", &["-U"]).status, Some(0));
    let engine = start("halrun", &["machine.hal"]);
    until("it runs", || run("halcmd", &["getp", "t.threadbeat"]).status == Some(0));
    let modes = |path: &Path| fs::metadata(path).unwrap().mode() & 0o7777;
    assert_eq!((modes(place.folder()), modes(&place.socket())), (0o700, 0o600));
    assert_eq!(fs::metadata(place.socket()).unwrap().uid(), USER);
    assert_eq!(run("halrun", &["-U"]).status, Some(0));
    assert_eq!(engine.wait().status, Some(0));
    fs::remove_dir(place.folder()).unwrap();

    folder_of(OTHER, place.folder());
    mode(place.folder(), 0o777);
    let listener = listen(OTHER, &place.socket());
    let want = format!("{} belongs to user {OTHER}, not to user {USER}", place.folder().display());
    let served = std::thread::scope(|scope| {
        let server = scope.spawn(|| impersonate(&listener));
        let outputs = [
            ("halcmd", &["getp", "spindle.on"][..]),
            ("halcmd", &["setp", "spindle.on", "1"]),
            ("halcmd", &["-f", "machine.hal"]),
            ("halrun", &["machine.hal"]),
            ("halrun", &["-U"]),
            ("halsampler", &[]),
            ("halstreamer", &[]),
            ("halscope", &["capture", "spindle.on"]),
            ("hal_manualtoolchange", &[]),
        ]
        .map(|(program, words)| (format!("{program} {words:?}"), run(program, words)));
        writeln!(UnixStream::connect(place.socket()).unwrap(), "end").unwrap();
        for (what, output) in outputs {
            let all = output.stdout + &output.stderr;
            assert!(all.contains(&want), "{what}: {all}");
            assert!(all.contains("name a folder of this user's own in HAL_RUNTIME_DIR"), "{all}");
            assert!(!matches!(output.status, None | Some(0)), "{what}: {all}");
        }
        server.join().unwrap()
    });
    assert_eq!(served, 0, "nobody has connected to it");
}

/// A system service's folder (mode 0750) lets its group in. A client of another user than the service's and root is a guest:
/// it looks and gives commands as people elsewhere do, ends nothing, and is no other process.
#[test]
fn a_system_service_lets_its_group_in_as_guests() {
    const SERVICE: u32 = 801;
    if !is_root() {
        return;
    }
    let reachable = std::process::Command::new(programs().join("halcmd")).uid(USER).output();
    if reachable.is_err() {
        return hal_tests::tools::report("another user cannot run the programs under test");
    }
    let (scratch, tmp) = temporary("service");
    let place = Place::at(tmp.join("ferrule"), "default").unwrap();
    folder_of(SERVICE, place.folder());
    mode(place.folder(), 0o750);
    let machine = tmp.join("machine.hal");
    let script = "loadrt threads name1=t period1=1000000\nloadrt and2\naddf and2.0 t\nloadrt iocontrol\n\
                  net enable iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in\n\
                  net changed => iocontrol.0.tool-changed\nstart\n";
    fs::write(&machine, script).unwrap();
    let start = |user: u32, groups: &str, words: &[&str]| -> Running {
        let mut command = scratch.command(&[], "halcmd");
        command.env("HAL_RUNTIME_DIR", &tmp).env_remove("XDG_RUNTIME_DIR").env("TMPDIR", &tmp);
        let mut as_user = std::process::Command::new("setpriv");
        as_user.envs(command.get_envs().filter_map(|(name, value)| Some((name, value?))));
        let user = user.to_string();
        as_user.args(["--reuid", &user, "--regid", &user]);
        match groups {
            "" => as_user.arg("--clear-groups"),
            groups => as_user.args(["--groups", groups]),
        };
        as_user.arg(programs().join(words[0])).args(&words[1..]);
        scratch.start(as_user.current_dir(&tmp))
    };
    let run = |user: u32, groups: &str, words: &[&str]| start(user, groups, words).wait();
    let group = SERVICE.to_string();
    let guest = |words: &[&str]| run(USER, &group, words);
    let engine = start(SERVICE, "", &["halrun", "machine.hal"]);
    until("it runs", || run(SERVICE, "", &["halcmd", "getp", "and2.0.out"]).status == Some(0));
    let modes = |path: &Path| fs::metadata(path).unwrap().mode() & 0o7777;
    assert_eq!((modes(place.folder()), modes(&place.socket())), (0o750, 0o660));
    assert_eq!(fs::metadata(place.socket()).unwrap().gid(), SERVICE);
    let far = "this is done at the machine, and not from afar";
    for (words, want) in [
        (&["halcmd", "getp", "and2.0.out"][..], Ok("FALSE\n")),
        (&["halcmd", "setp", "and2.0.in0", "1"], Ok("")),
        (&["halcmd", "iocontrol.estop"], Ok("")),
        (&["halcmd", "loadrt", "or2"], Err(far)),
        (&["halcmd", "stop"], Err(far)),
        (&["halcmd", "record", "x.vcd"], Err(far)),
        (&["halcmd", "loadusr", "sleep", "1"], Err(far)),
        (&["halcmd", "shutdown"], Err(far)),
    ] {
        let output = guest(words);
        match want {
            Ok(text) => {
                assert_eq!(
                    (output.status, &*output.stdout),
                    (Some(0), text),
                    "{words:?} {}",
                    output.stderr
                );
            }
            Err(text) => {
                assert!(
                    output.stderr.contains(text),
                    "{words:?}: {} {}",
                    output.stdout,
                    output.stderr
                );
                assert_ne!(output.status, Some(0), "{words:?}");
            }
        }
    }
    assert_ne!(guest(&["halrun", "-U"]).status, Some(0), "a guest does not end it");
    // A guest is the process that the kernel says.
    let true_one = as_guest(SERVICE, &place);
    assert_eq!(true_one, std::process::id().cast_signed());
    // Nobody else reaches the socket.
    let stranger = run(OTHER, "", &["halcmd", "getp", "and2.0.out"]);
    assert!(stranger.stderr.contains("Permission denied"), "{}", stranger.stderr);
    // A folder that is not named, and one of a person, let nobody in.
    let person = Place::at(tmp.join("person"), "default").unwrap();
    folder_of(OTHER, person.folder());
    mode(person.folder(), 0o750);
    assert!(refusal(USER, &person).contains("belongs to user"), "{}", refusal(USER, &person));
    assert_eq!(run(SERVICE, "", &["halcmd", "getp", "and2.0.in0"]).stdout, "TRUE\n");
    assert_eq!(run(SERVICE, "", &["halrun", "-U"]).status, Some(0));
    assert_eq!(engine.wait().status, Some(0));
}

/// Joins as a guest that says another process id than its own, and returns the id that the engine lists.
fn as_guest(group: u32, place: &Place) -> i32 {
    use rustix::{
        process::{Gid, Uid},
        thread::{set_thread_groups, set_thread_res_gid, set_thread_res_uid},
    };
    let work = || {
        let (uid, gid) = (Uid::from_raw(USER), Gid::from_raw(USER));
        set_thread_groups(&[Gid::from_raw(group)]).unwrap();
        set_thread_res_gid(gid, gid, gid).unwrap();
        set_thread_res_uid(uid, uid, uid).unwrap();
        let mut socket = UnixStream::connect(place.socket()).unwrap();
        let mut lines = BufReader::new(socket.try_clone().unwrap()).lines();
        let mut call = |request: &Request| {
            writeln!(
                socket,
                "{}",
                serde_json::to_string(&WireRequest { request: request.clone(), at: None }).unwrap()
            )
            .unwrap();
            lines.next().unwrap().unwrap()
        };
        let hello = Request::Hello { protocol: hal_protocol::LATEST, name: "guest".into(), pid: 1 };
        let said = call(&hello);
        assert!(said.contains("hello"), "{said}");
        let kind = hal_protocol::Kind::Components;
        let listed = call(&Request::List { kind, patterns: vec!["guest".into()], ty: None });
        // Its own pin reads any signal, and writes to none that leads to a component that takes commands.
        call(&Request::Join { name: "reader".into(), poll_ns: 0 });
        for (pin, direction, want) in [
            ("reader.in", Direction::In, "{\"ok\":\"done\"}"),
            ("reader.out", Direction::Out, "iocontrol"),
        ] {
            let name = pin.to_owned();
            call(&Request::NewPin { name, ty: Type::Bit, direction });
            let said = call(&Request::Net { signal: "changed".into(), pins: vec![pin.into()] });
            assert!(said.contains(want), "{pin}: {said}");
        }
        let after = listed.split("\"pid\":").nth(1).unwrap_or_default();
        after.split(|c: char| !c.is_ascii_digit()).next().unwrap_or_default().parse().unwrap_or(0)
    };
    std::thread::scope(|scope| scope.spawn(work).join().unwrap())
}

/// Rules that hold for every user: names that lead nowhere else, and modes that do not depend on the umask.
#[test]
fn an_instance_has_a_name_and_its_files_their_modes() {
    let scratch = Scratch::new("modes");
    scratch.write("machine.hal", "loadrt threads name1=t period1=1000000\nstart\n");
    for name in ["../x", "a/b", "..", ".", "/tmp/x"] {
        for (program, words) in [("halcmd", &["show", "pin"][..]), ("halrun", &["-U"])] {
            let mut command = scratch.command(&[], program);
            let output = scratch.run(command.env("HAL_INSTANCE", name).args(words));
            assert!(!matches!(output.status, None | Some(0)), "{program} {name}: {output:?}");
            let want = format!("instance name '{name}' is not usable");
            assert!(output.stderr.contains(&want), "{}", output.stderr);
        }
    }
    assert_eq!(scratch.left(), [""; 0]);
    let mut open = scratch.command(&["sh", "-c", "umask 000; exec \"$@\"", "sh"], "halrun");
    let mut running = scratch.start(open.args(["--virtual", "--hold", "machine.hal"]));
    let place = scratch.place("default");
    until("it runs", || {
        assert!(running.is_running(), "{:?}", running.said());
        Client::connect(&place, "").map_err(|e| assert_eq!(e.code, NOT_RUNNING)).is_ok()
    });
    for (path, want) in [(place.folder(), 0o700), (&place.socket(), 0o600), (&place.lock(), 0o600)]
    {
        assert_eq!(fs::metadata(path).unwrap().mode() & 0o7777, want, "{}", path.display());
    }
    assert_eq!(scratch.halrun(&["-U"]).status, Some(0));
    assert_eq!(running.wait().status, Some(0));
}
