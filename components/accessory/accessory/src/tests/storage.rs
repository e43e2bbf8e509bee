//! Jobs on the storage: presented by a folder like configfs, taken from a folder of programs.

use super::{MS, Scratch, hardware};
use crate::usbjobs::UsbJobs;
use hal_bench::Bench;

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
        for _ in 0..12 {
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
