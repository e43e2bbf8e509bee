//! Jobs on the storage: presented by a folder like configfs, taken from a folder of programs.

use super::{MS, Scratch, hardware};
use crate::{
    programs_folder::{MAX_FILES, ProgramsFolder},
    usbjobs::UsbJobs,
};
use hal_bench::Bench;
use hal_component::Component as _;

/// The whole storage with a folder that looks like the kernel's.
#[test]
fn a_job_is_presented_by_configfs() {
    let scratch = Scratch::new("configfs");
    std::fs::create_dir_all(scratch.0.join("mass_storage.0/lun.0")).unwrap();
    for name in ["file", "ro", "forced_eject"] {
        std::fs::write(scratch.0.join("mass_storage.0/lun.0").join(name), "").unwrap();
    }
    let lun = scratch.path("mass_storage.0/lun.0/file");
    std::fs::create_dir(scratch.0.join("jobs")).unwrap();
    let job = scratch.path("part.nc");
    std::fs::write(&job, "G0 X1\nM30\n").unwrap();
    let mut bench = hardware();
    let args = [
        format!("folder={}", scratch.path("jobs")),
        format!("function={}", scratch.path("mass_storage.0")),
        "size=36".to_owned(),
    ];
    bench.load::<UsbJobs>(&args.each_ref().map(String::as_str)).unwrap();
    bench.work("usbjobs", 8).unwrap();
    let shown = || std::fs::read_to_string(&lun).unwrap();
    assert!(shown().trim_end().ends_with("jobs/a.img"), "{}", shown());
    bench.command("usbjobs.send", &[&format!("file={job}")]).unwrap();
    for _ in 0..5 {
        bench.work("usbjobs", 8).unwrap();
    }
    assert_eq!((bench.get::<u32>("usbjobs.state"), bench.get::<i32>("usbjobs.medium")), (2, 1));
    bench.set("usbjobs.idle", true);
    bench.work("usbjobs", 8).unwrap();
    assert_eq!(bench.get::<i32>("usbjobs.medium"), 2);
    assert!(shown().trim_end().ends_with("jobs/b.img"), "{}", shown());
    let status = bench.command("usbjobs.status", &[]).unwrap();
    assert_eq!(status, ["serving image B", "ready part.nc"]);
    // Without a function in that folder the load fails, and says where.
    let mut bench = hardware();
    let args = [format!("folder={}", scratch.path("jobs")), format!("function={job}")];
    let error = bench.load::<UsbJobs>(&args.each_ref().map(String::as_str)).unwrap_err();
    assert!(error.contains(&format!("function {job}")), "{error}");
}

#[test]
fn without_a_folder_commands_are_refused() {
    let mut bench = Bench::new();
    bench.load::<UsbJobs>(&[]).unwrap();
    let error = bench.command_from_afar("usbjobs.send", &["file=/etc/hostname"]).unwrap_err();
    assert_eq!(error, "a file is named at the machine, and not from afar");
    let error = bench.command("usbjobs.send", &["file=/etc/hostname"]).unwrap_err();
    assert_eq!(error, "usbjobs has no storage: load it with folder=PATH");
}

/// Files that appear in the folder of programs are jobs; those that are on the image already are not sent again.
#[test]
fn a_folder_of_programs_is_sent() {
    let scratch = Scratch::new("programs");
    let programs = scratch.0.join("programs");
    std::fs::create_dir_all(programs.join("folder")).unwrap();
    std::fs::create_dir(scratch.0.join("jobs")).unwrap();
    std::fs::write(programs.join("first.nc"), "M30\n").unwrap();
    std::fs::write(programs.join(".part.nc"), "M30\n").unwrap();
    let args = [
        format!("folder={}", scratch.path("jobs")),
        format!("programs={}", programs.display()),
        "size=36".to_owned(),
    ];
    let load = || {
        let mut bench = Bench::new();
        bench.load::<UsbJobs>(&args.each_ref().map(String::as_str)).unwrap();
        bench.set("usbjobs.idle", true);
        bench
    };
    let settle = |bench: &Bench| {
        for _ in 0..40 {
            bench.pass(100 * MS);
            bench.work("usbjobs", 8).unwrap();
        }
        bench.command("usbjobs.status", &[]).unwrap()
    };
    let bench = load();
    assert_eq!(settle(&bench), ["serving image B", "ready first.nc"]);
    std::fs::write(programs.join("second.nc"), "G0 X1\nM30\n").unwrap();
    std::fs::write(programs.join("empty.nc"), "").unwrap();
    assert_eq!(settle(&bench), ["serving image A", "ready first.nc", "ready second.nc"]);
    let said = bench.said();
    assert!(said.iter().any(|line| line.contains("job 'empty.nc' is empty")), "{said:?}");
    drop(bench);
    // Up again: nothing is sent that is there.
    let bench = load();
    assert_eq!(settle(&bench), ["serving image A", "ready first.nc", "ready second.nc"]);
    assert_eq!(bench.get::<u32>("usbjobs.swaps"), 1);
    std::fs::remove_dir_all(&programs).unwrap();
    settle(&bench);
    let lost = bench.said().into_iter().filter(|line| line.contains("the folder of programs"));
    assert_eq!(lost.count(), 1);
}

/// More files than can wait all arrive; a file that is being written waits until it is whole.
#[test]
fn no_file_of_the_folder_is_lost_and_none_is_sent_in_part() {
    let scratch = Scratch::new("many");
    let programs = scratch.0.join("programs");
    std::fs::create_dir(scratch.0.join("jobs")).unwrap();
    let args = [
        format!("folder={}", scratch.path("jobs")),
        format!("programs={}", programs.display()),
        "size=36".to_owned(),
    ];
    let mut bench = Bench::new();
    bench.load::<UsbJobs>(&args.each_ref().map(String::as_str)).unwrap();
    bench.set("usbjobs.idle", true);
    let pass = |seconds: u32| {
        for _ in 0..seconds * 10 {
            bench.pass(100 * MS);
            bench.work("usbjobs", 1000).unwrap();
        }
        bench.command("usbjobs.status", &[]).unwrap()
    };
    // The folder is not there at first.
    pass(2);
    std::fs::create_dir(&programs).unwrap();
    let name = |n: u32| programs.join(format!("{n:02}.nc"));
    for n in 0..70 {
        std::fs::write(name(n), "M30\n").unwrap();
    }
    let status = pass(8);
    assert_eq!(status.iter().filter(|line| line.starts_with("ready")).count(), 70, "{status:?}");
    // A file that grows is not sent before it has stopped.
    let mut text = "G0 X1\n".to_owned();
    for _ in 0..5 {
        std::fs::write(programs.join("grows.nc"), &text).unwrap();
        assert!(!pass(1).iter().any(|line| line.contains("grows.nc")));
        text.push_str("G0 X2\n");
    }
    assert!(pass(4).contains(&"ready grows.nc".to_owned()));
    let said = bench.said();
    assert_eq!(
        said.iter().filter(|line| line.contains("ERROR") || line.contains("wait")).count(),
        0
    );
}

/// An instance that begins while its image is presented leaves it; the kernel refuses to change `ro` beside an image.
#[test]
fn an_image_that_is_presented_stays_and_another_goes() {
    let scratch = Scratch::new("again");
    let lun = scratch.0.join("mass_storage.0/lun.0");
    std::fs::create_dir_all(&lun).unwrap();
    std::fs::create_dir(scratch.0.join("jobs")).unwrap();
    let args = [
        format!("folder={}", scratch.path("jobs")),
        format!("function={}", scratch.path("mass_storage.0")),
        "size=36".to_owned(),
    ];
    for (shown, read_only, wanted) in [
        ("", "0\n", "1\n"),
        // The blank stays if nobody writes the file.
        ("jobs/a.img", "1 \n", "1 \n"),
        ("jobs/b.img", "1 \n", "1 \n"),
    ] {
        let shown = if shown.is_empty() { String::new() } else { scratch.path(shown) };
        std::fs::write(lun.join("file"), format!("{shown}\n")).unwrap();
        std::fs::write(lun.join("ro"), read_only).unwrap();
        let mut bench = hardware();
        bench.load::<UsbJobs>(&args.each_ref().map(String::as_str)).unwrap();
        bench.work("usbjobs", 8).unwrap();
        assert_eq!(bench.get::<i32>("usbjobs.medium"), 1);
        let file = std::fs::read_to_string(lun.join("file")).unwrap();
        assert!(file.trim_end().ends_with("jobs/a.img"), "{file}");
        assert_eq!(std::fs::read_to_string(lun.join("ro")).unwrap(), wanted);
    }
}

/// Another size is that of the next image: the presented one keeps its length and its jobs.
#[test]
fn another_size_changes_no_image_that_is_presented() {
    let scratch = Scratch::new("size");
    std::fs::create_dir(scratch.0.join("jobs")).unwrap();
    let job = scratch.path("part.nc");
    std::fs::write(&job, "M30\n").unwrap();
    let load = |size: &str| {
        let mut bench = Bench::new();
        bench.load::<UsbJobs>(&[&format!("folder={}", scratch.path("jobs")), size]).unwrap();
        bench.set("usbjobs.idle", true);
        bench.work("usbjobs", 8).unwrap();
        bench
    };
    let len = |image: &str| std::fs::metadata(scratch.path(image)).unwrap().len() >> 20;
    let bench = load("size=40");
    drop(bench);
    let bench = load("size=36");
    assert_eq!(len("jobs/a.img"), 40);
    bench.command("usbjobs.send", &[&format!("file={job}")]).unwrap();
    bench.work("usbjobs", 100).unwrap();
    assert_eq!(bench.command("usbjobs.status", &[]).unwrap(), ["serving image B", "ready part.nc"]);
    assert_eq!((len("jobs/a.img"), len("jobs/b.img")), (40, 36));
}

/// Files beyond the largest number are left out by their names, and that is reported once.
#[test]
fn a_folder_with_too_many_files_is_reported_once() {
    let scratch = Scratch::new("crowded");
    let programs = scratch.0.join("programs");
    std::fs::create_dir_all(&programs).unwrap();
    std::fs::create_dir(scratch.0.join("jobs")).unwrap();
    let names: Vec<String> = (0..MAX_FILES + 2).map(|n| format!("{n:04}.nc")).collect();
    // The order in which they come into the folder is not that of their names.
    for name in names.iter().rev() {
        std::fs::write(programs.join(name), "M30\n").unwrap();
    }
    let mut folder = ProgramsFolder::new(&programs);
    let first = folder.look(0.0, |_| false);
    assert!(first.is_crowded && first.changed.is_empty());
    let second = folder.look(1.0, |_| false);
    assert!(!second.is_crowded);
    assert!(second.changed == names[..MAX_FILES], "{:?}", second.changed.first());
    // As many as there may be are not too many.
    names[..2].iter().for_each(|name| std::fs::remove_file(programs.join(name)).unwrap());
    assert!(!folder.look(2.0, |_| false).is_crowded);
    let fourth = folder.look(3.0, |_| false);
    assert!(fourth.changed == names[2..], "{:?}", fourth.changed.first());
    std::fs::write(programs.join(&names[0]), "M30\n").unwrap();
    assert!(folder.look(4.0, |_| false).is_crowded, "again too many");
    let mut bench = Bench::new();
    let args = [
        format!("folder={}", scratch.path("jobs")),
        format!("programs={}", programs.display()),
        "size=36".to_owned(),
    ];
    bench.load::<UsbJobs>(&args.each_ref().map(String::as_str)).unwrap();
    for _ in 0..3 {
        bench.work("usbjobs", 0).unwrap();
        bench.pass(1000 * MS);
    }
    let said = bench.said();
    let crowded = format!("the folder of programs has more than {MAX_FILES} files");
    assert_eq!(said.iter().filter(|line| line.contains(&crowded)).count(), 1, "{said:?}");
    assert!(UsbJobs::DOC.contains(&format!("the first {MAX_FILES} by their names")));
}
