//! The double image: swaps, busy hosts, power cuts, full and damaged images.
#![expect(clippy::unwrap_used, clippy::indexing_slicing, clippy::print_stderr, reason = "tests")]

mod rig;

use hal_storage::{
    Configfs, Folder, Gadget, Phase, Rules, Side, Storage, StorageError, image, safe_name,
};
use rig::{Host, Memory, RULES, SIZE, files, read, reported, served, settle};

#[test]
fn a_job_appears_on_the_other_image() {
    let memory = Memory::default();
    let (mut storage, mut host) = served(&memory, RULES);
    assert_eq!((host.sees, files(&memory, Side::A).len()), (Some(Side::A), 0));
    assert_eq!(storage.send("../jobs/plate 1.nc", b"G0 X1\n").unwrap(), "plate 1.nc");
    assert_eq!(settle(&mut storage, &mut host, 1.0), ["presented B"]);
    assert_eq!(host.sees, Some(Side::B));
    assert_eq!(read(&memory, Side::B, "plate 1.nc"), b"G0 X1\n");
    assert!(storage.waiting().is_empty() && memory.0.borrow().jobs.is_empty());
    // The next job: the image has both, and the same name replaces.
    storage.send("b.nc", b"2").unwrap();
    storage.send("PLATE 1.NC", b"3").unwrap();
    assert_eq!(settle(&mut storage, &mut host, 2.0), ["presented A"]);
    assert_eq!(files(&memory, Side::A), ["PLATE 1.NC", "b.nc"]);
    assert_eq!(read(&memory, Side::A, "PLATE 1.NC"), b"3");
}

/// All jobs that wait take one swap.
#[test]
fn many_jobs_take_one_swap() {
    let memory = Memory::default();
    let (mut storage, mut host) = served(&memory, RULES);
    for n in 0..64 {
        storage.send(&format!("{n:02}.nc"), b"G0").unwrap();
    }
    let error = storage.send("one more.nc", b"G0").unwrap_err();
    assert_eq!(error.to_string(), "64 jobs wait already");
    assert_eq!(
        storage.send("00.nc", b"G1").unwrap(),
        "00.nc",
        "the same name takes no further place"
    );
    assert_eq!(settle(&mut storage, &mut host, 1.0), ["presented B"]);
    assert_eq!(host.asked, 1);
    assert_eq!(files(&memory, Side::B).len(), 64);
    assert_eq!(read(&memory, Side::B, "00.nc"), b"G1");
}

#[test]
fn a_hundred_jobs_one_after_the_other_are_all_there() {
    let memory = Memory::default();
    let (mut storage, mut host) = served(&memory, RULES);
    for n in 0..100_u32 {
        let text = format!("N{n} G0 X{n}\n").repeat(50);
        storage.send(&format!("job {n}.nc"), text.as_bytes()).unwrap();
        let reported = settle(&mut storage, &mut host, f64::from(n));
        assert_eq!(reported, [if n % 2 == 0 { "presented B" } else { "presented A" }], "job {n}");
    }
    let side = host.sees.unwrap();
    assert_eq!(files(&memory, side).len(), 100);
    for n in 0..100 {
        let text = format!("N{n} G0 X{n}\n").repeat(50);
        assert_eq!(read(&memory, side, &format!("job {n}.nc")), text.as_bytes(), "job {n}");
    }
}

#[test]
fn above_80_percent_the_oldest_finished_jobs_go() {
    let memory = Memory::default();
    let (mut storage, mut host) = served(&memory, RULES);
    let big = vec![b'x'; 9 << 20];
    for name in ["1", "2", "3"] {
        storage.send(name, &big).unwrap();
        settle(&mut storage, &mut host, 0.0);
    }
    // Four do not fit while none is finished.
    storage.send("4", &big).unwrap();
    let reported = settle(&mut storage, &mut host, 0.0);
    assert!(reported[0].starts_with("the jobs have 37748736 bytes together"), "{reported:?}");
    assert_eq!(
        (storage.phase(), storage.waiting(), host.sees),
        (Phase::Serving, &["4".to_owned()][..], Some(Side::B))
    );
    assert_eq!(settle(&mut storage, &mut host, 1.0), [""; 0], "it waits for a user");
    storage.finish("3").unwrap();
    storage.finish("2").unwrap();
    storage.retry();
    // 27 of 36 MB are below 80 %: the oldest finished one was enough.
    assert_eq!(settle(&mut storage, &mut host, 2.0), ["deleted 2", "presented A"]);
    assert_eq!(files(&memory, Side::A), ["1", "3", "4"]);
    assert_eq!(storage.finish("2").unwrap_err().to_string(), "no job has the name '2'");
}

#[test]
fn a_busy_host_is_asked_for_five_seconds_and_then_waited_for() {
    let memory = Memory::default();
    let (mut storage, mut host) = served(&memory, RULES);
    host.is_busy = true;
    storage.send("a.nc", b"1").unwrap();
    assert_eq!(settle(&mut storage, &mut host, 10.0), [""; 0]);
    assert_eq!(storage.phase(), Phase::Ejecting);
    assert_eq!(settle(&mut storage, &mut host, 14.9), [""; 0]);
    let text = "the host has held the medium for 5 s: stop its job, or allow a forced eject";
    assert_eq!(settle(&mut storage, &mut host, 15.0), [text]);
    assert_eq!(settle(&mut storage, &mut host, 60.0), [""; 0], "the failure is reported once");
    assert_eq!((host.sees, host.forced), (Some(Side::A), 0));
    host.is_busy = false;
    assert_eq!(settle(&mut storage, &mut host, 61.0), ["presented B"]);
}

#[test]
fn a_forced_eject_comes_after_five_seconds_if_it_is_allowed() {
    let memory = Memory::default();
    let (mut storage, mut host) = served(&memory, Rules { may_force: true, ..RULES });
    host.is_busy = true;
    storage.send("a.nc", b"1").unwrap();
    settle(&mut storage, &mut host, 10.0);
    settle(&mut storage, &mut host, 14.0);
    assert_eq!(host.forced, 0);
    assert_eq!(settle(&mut storage, &mut host, 15.0), ["forced A", "presented B"]);
    assert_eq!((host.sees, host.forced), (Some(Side::B), 1));
}

/// While the controller runs a job nothing is ejected, whatever the device would allow.
#[test]
fn a_running_controller_keeps_its_image() {
    let memory = Memory::default();
    let (mut storage, mut host) = served(&memory, Rules { may_force: true, ..RULES });
    storage.send("a.nc", b"1").unwrap();
    for n in 0..100 {
        storage.step(&mut host, f64::from(n), false);
    }
    assert_eq!((storage.phase(), host.sees, host.asked), (Phase::Ejecting, Some(Side::A), 0));
    // A job that comes meanwhile is on the same image.
    storage.send("b.nc", b"2").unwrap();
    assert_eq!(settle(&mut storage, &mut host, 200.0), ["presented B"]);
    assert_eq!(files(&memory, Side::B), ["a.nc", "b.nc"]);
}

#[test]
fn a_job_that_is_sent_again_or_cancelled_meanwhile_begins_again() {
    let memory = Memory::default();
    let (mut storage, mut host) = served(&memory, RULES);
    storage.send("a.nc", b"old").unwrap();
    storage.send("b.nc", b"b").unwrap();
    while storage.phase() != Phase::Ejecting {
        storage.step(&mut host, 0.0, false);
    }
    storage.send("a.nc", b"new").unwrap();
    storage.cancel("B.NC").unwrap();
    assert_eq!(storage.cancel("b.nc").unwrap_err().to_string(), "no job has the name 'b.nc'");
    assert_eq!(settle(&mut storage, &mut host, 0.0), ["presented B"]);
    assert_eq!(files(&memory, Side::B), ["a.nc"]);
    assert_eq!(read(&memory, Side::B, "a.nc"), b"new");
}

#[test]
fn a_device_that_fails_leaves_the_image_and_the_jobs() {
    let memory = Memory::default();
    let (mut storage, mut host) = served(&memory, RULES);
    host.is_broken = true;
    storage.send("a.nc", b"1").unwrap();
    assert_eq!(settle(&mut storage, &mut host, 0.0), ["USB device, image A: no such device"]);
    assert_eq!(
        (storage.phase(), storage.is_paused(), host.sees),
        (Phase::Serving, true, Some(Side::A))
    );
    host.is_broken = false;
    storage.retry();
    assert_eq!(settle(&mut storage, &mut host, 0.0), ["presented B"]);
    // A device that does not take an image is tried again, once in a second.
    let mut storage = Storage::open(memory, RULES).unwrap();
    let mut host = Host { is_broken: true, ..Host::default() };
    assert_eq!(settle(&mut storage, &mut host, 0.0), ["USB device, image B: no such device"]);
    assert_eq!(settle(&mut storage, &mut host, 5.0), [""; 0]);
    host.is_broken = false;
    settle(&mut storage, &mut host, 5.5);
    assert_eq!((storage.phase(), storage.presented()), (Phase::Presenting, None));
    assert_eq!(settle(&mut storage, &mut host, 6.0), ["presented B"]);
}

/// A disk that loses what is written to it is found by reading back.
#[test]
fn what_reads_back_otherwise_is_not_presented() {
    let memory = Memory::default();
    let (mut storage, mut host) = served(&memory, RULES);
    memory.0.borrow_mut().lost_after = Some((Side::B, memory.find(Side::A, b"JOBS       ") + 512));
    storage.send("a.nc", &[b'x'; 5000]).unwrap();
    let reported = settle(&mut storage, &mut host, 0.0);
    assert_eq!(reported.len(), 1);
    assert!(reported[0].starts_with("image B"), "{reported:?}");
    assert_eq!((host.sees, storage.waiting()), (Some(Side::A), &["a.nc".to_owned()][..]));
    memory.0.borrow_mut().lost_after = None;
    storage.retry();
    assert_eq!(settle(&mut storage, &mut host, 0.0), ["presented B"]);
}

/// The power is cut before each write in turn, from the job's arrival to the presented image; each time the storage
/// comes up with an image that has every job that was presented, and in the end with all jobs that were kept.
#[test]
fn a_power_cut_loses_no_job_whenever_it_comes() {
    let before = Memory::default();
    let (mut storage, mut host) = served(&before, RULES);
    storage.send("old.nc", b"the old job").unwrap();
    settle(&mut storage, &mut host, 0.0);
    drop(storage);
    let begin = before.0.borrow().clone();
    let whole = {
        let memory = Memory(std::rc::Rc::new(begin.clone().into()));
        let (mut storage, mut host) = served(&memory, RULES);
        storage.send("new.nc", &[b'n'; 3000]).unwrap();
        settle(&mut storage, &mut host, 0.0);
        let writes = memory.0.borrow().writes;
        writes - begin.writes
    };
    assert!(whole > 500, "{whole} writes");
    // The long middle is the zeroing of tables.
    let cuts = (0..whole).filter(|n| *n < 40 || n % 41 == 0 || *n + 120 > whole);
    let mut resumed = [0; 2];
    for cut in cuts {
        let mut kept = begin.clone();
        kept.power = Some(cut);
        let memory = Memory(std::rc::Rc::new(kept.into()));
        let (mut storage, mut host) = served(&memory, RULES);
        let sent = storage.send("new.nc", &[b'n'; 3000]).is_ok();
        settle(&mut storage, &mut host, 0.0);
        drop(storage);
        memory.0.borrow_mut().power = None;
        // Up again: first the image of the state file, as it was complete.
        let mut storage = Storage::open(memory.clone(), RULES).unwrap();
        let mut host = Host::default();
        while host.sees.is_none() {
            storage.step(&mut host, 0.0, false);
        }
        let side = host.sees.unwrap();
        assert_eq!(read(&memory, side, "old.nc"), b"the old job", "cut {cut}");
        resumed[usize::from(files(&memory, side).len() == 2)] += 1;
        settle(&mut storage, &mut host, 0.0);
        let side = host.sees.unwrap();
        let names = files(&memory, side);
        assert_eq!(names, if sent { &["new.nc", "old.nc"][..] } else { &["old.nc"] }, "cut {cut}");
        if sent {
            assert_eq!(read(&memory, side, "new.nc"), [b'n'; 3000], "cut {cut}");
        }
    }
    assert!(resumed[0] > 100 && resumed[1] > 0, "{resumed:?}");
}

#[test]
fn wrong_state_files_are_refused_by_line() {
    let check = |text: &[u8], expected: &str| {
        let memory = Memory::default();
        memory.0.borrow_mut().state = Some(text.to_vec());
        let error = Storage::open(memory.clone(), RULES).map(|_| ()).unwrap_err();
        assert_eq!(error.to_string(), expected);
        assert_eq!(memory.0.borrow().state.as_deref(), Some(text), "nothing is changed");
    };
    check(b"", "the state file, line 1: must be 'presented a' or 'presented b'");
    check(b"presented c\n", "the state file, line 1: must be 'presented a' or 'presented b'");
    check(b"\xff\xfe", "the state file, line 1: it is not UTF-8");
    let job = "must be 'job NUMBER ready NAME' or 'job NUMBER finished NAME'";
    for line in
        ["job", "job x ready a", "job 1 maybe a", "job 1 ready ", "job 1 ready ../a", "\u{0}"]
    {
        check(
            format!("presented a\njob 1 ready ok\n{line}\n").as_bytes(),
            &format!("the state file, line 3: {job}"),
        );
    }
    let many = format!("presented a\n{}", "job 1 ready a\n".repeat(4097));
    check(many.as_bytes(), "the state file, line 4098: there are more than 4096 jobs");
    // The image that it names must be one.
    let memory = Memory::default();
    memory.0.borrow_mut().state = Some(b"presented b\n".to_vec());
    let error = Storage::open(memory, RULES).map(|_| ()).unwrap_err();
    assert!(matches!(error, StorageError::Image(Side::B, None, _)), "{error}");
}

#[test]
fn wrong_jobs_are_refused() {
    let memory = Memory::default();
    let (mut storage, _) = served(&memory, RULES);
    let mut refused = |name: &str, bytes: &[u8]| storage.send(name, bytes).unwrap_err().to_string();
    assert_eq!(refused("a.nc", b""), "job 'a.nc' is empty");
    assert_eq!(refused("", b"1"), "job '': the name has no letter or digit");
    assert_eq!(refused("..", b"1"), "job '..': the name has no letter or digit");
    assert_eq!(refused("dir/", b"1"), "job 'dir/': the name has no letter or digit");
    let long = "x".repeat(65);
    assert_eq!(
        refused(&long, b"1"),
        format!("job '{long}': the name is longer than 64 characters")
    );
    let large = vec![0; (16 << 20) + 1];
    assert_eq!(
        refused("large.nc", &large),
        "job 'large.nc' has 16777217 bytes, the most is 16777216"
    );
    assert!(memory.0.borrow().jobs.is_empty());
}

#[test]
fn names_are_made_safe() {
    for (given, safe) in [
        ("part.nc", "part.nc"),
        ("C:\\jobs\\part.nc", "part.nc"),
        ("/etc/passwd", "passwd"),
        ("a\u{0}b\nc.nc", "a_b_c.nc"),
        ("ñandú.nc", "_and_.nc"),
        ("a*?:<>|\".nc", "a_______.nc"),
        (".hidden", "hidden"),
        ("dots...", "dots"),
        ("con", "_con"),
        ("COM1.nc", "_COM1.nc"),
        ("comb.nc", "comb.nc"),
        ("lpt9", "_lpt9"),
    ] {
        assert_eq!(safe_name(given).as_deref(), Ok(safe), "{given:?}");
        assert_eq!(safe_name(safe).as_deref(), Ok(safe), "a safe name stays");
    }
}

/// Damaged images are errors, never a panic or an endless read.
#[test]
fn damaged_images_are_errors() {
    let memory = Memory::default();
    let (mut storage, mut host) = served(&memory, RULES);
    storage.send("a.nc", &[b'x'; 20_000]).unwrap();
    storage.send("a longer name.nc", b"y").unwrap();
    settle(&mut storage, &mut host, 0.0);
    let good = memory.0.borrow().clone();
    let table = memory.find(Side::B, &[0xF8, 0xFF, 0xFF, 0x0F]);
    let folder = memory.find(Side::B, b"A       NC ");
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(|_| {}));
    let (mut seed, mut failed) = (7_u64, 0);
    let mut draw = |most: u64| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) % most
    };
    for round in 0..400 {
        *memory.0.borrow_mut() = good.clone();
        for _ in 0..=round % 4 {
            // The first sector, the tables, the folder.
            let at = match round % 3 {
                0 => draw(512),
                1 => table + draw(256),
                _ => folder + draw(256),
            };
            memory.damage(Side::B, at, &[u8::try_from(draw(256)).unwrap()]);
        }
        let names = image::list(memory.disk(Side::B));
        failed += usize::from(names.is_err());
        for file in names.unwrap_or_default() {
            let read = image::read(memory.disk(Side::B), &file.name, 1 << 20);
            failed += usize::from(read.is_err());
        }
    }
    std::panic::set_hook(hook);
    eprintln!("{failed} of 400 rounds");
    assert!(failed > 20, "{failed} damaged images were found");
}

fn scratch(name: &str) -> std::path::PathBuf {
    let path = std::env::temp_dir().join(format!("ferrule-{name}-{}", std::process::id()));
    drop(std::fs::remove_dir_all(&path));
    std::fs::create_dir_all(&path).unwrap();
    path
}

/// Images as files, and a device that looks like configfs.
#[test]
fn a_folder_and_configfs_do_the_same() {
    let path = scratch("storage");
    let function = path.join("mass_storage.0");
    std::fs::create_dir_all(function.join("lun.0")).unwrap();
    for name in ["file", "ro", "forced_eject"] {
        std::fs::write(function.join("lun.0").join(name), "").unwrap();
    }
    let attribute =
        |name: &str| std::fs::read_to_string(function.join("lun.0").join(name)).unwrap();
    let missing = Folder::new(&path.join("jobs"), SIZE).unwrap_err();
    assert_eq!(missing.kind(), std::io::ErrorKind::NotFound);
    std::fs::create_dir(path.join("jobs")).unwrap();
    let folder = Folder::new(&path.join("jobs"), SIZE).unwrap();
    let images = [folder.image_path(Side::A), folder.image_path(Side::B)];
    let mut device = Configfs::new(&function, images.clone()).unwrap();
    let mut storage = Storage::open(folder.clone(), RULES).unwrap();
    storage.send("a.nc", b"G0 X1").unwrap();
    while storage.phase() != Phase::Serving || !storage.waiting().is_empty() {
        storage.step(&mut device, 0.0, true);
    }
    assert_eq!(attribute("file"), format!("{}\n", images[1].display()));
    assert_eq!(attribute("ro"), "1\n");
    let disk = std::fs::File::options().read(true).write(true).open(&images[1]).unwrap();
    assert_eq!(image::read(disk, "a.nc", 100).unwrap(), b"G0 X1");
    // The file system is one that others read too, if their program is here.
    if let Ok(check) = std::process::Command::new("fsck.fat").arg("-n").arg(&images[1]).output() {
        assert!(check.status.success(), "{}", String::from_utf8_lossy(&check.stdout));
    }
    // Up again, from the disk.
    let storage = Storage::open(folder, RULES).unwrap();
    assert_eq!(storage.ledger().presented, Side::B);
    device.force_eject().unwrap();
    assert_eq!(attribute("forced_eject"), "1\n");
    let missing = Configfs::new(&path.join("nothing"), images).unwrap_err();
    assert_eq!(missing.kind(), std::io::ErrorKind::NotFound);
    std::fs::remove_dir_all(&path).unwrap();
}

#[test]
fn sizes_that_fat32_has_not_are_errors() {
    let path = scratch("sizes");
    let folder = Folder::new(&path, 1 << 20).unwrap();
    let error = Storage::open(folder, RULES).map(|_| ()).unwrap_err();
    assert_eq!(error.to_string(), "image A: the size is not 36 MiB to 32 GiB");
    std::fs::remove_dir_all(&path).unwrap();
    assert!(reported(&mut served(&Memory::default(), RULES).0).is_empty());
}
