//! The first recipe of `components/README.md`, followed in a copy of the tree: its crate builds, and its component runs.
#![expect(clippy::unwrap_used, clippy::panic, reason = "tests")]

use hal_tests::{
    programs::{cargo, programs, root},
    scratch::Scratch,
};
use std::{
    fs,
    path::Path,
    process::{Command, Stdio},
};

/// Returns the first block of this language behind a heading.
fn block<'t>(page: &'t str, heading: &str, language: &str) -> &'t str {
    let behind = page.split_once(heading).unwrap_or_else(|| panic!("no {heading}")).1;
    let begin = format!("```{language}\n");
    let from = behind.split_once(&begin).unwrap_or_else(|| panic!("no {begin}")).1;
    from.split_once("\n```").unwrap().0
}

/// Copies the files that a build needs: those that git knows, without the data of tests.
fn copy_tree(to: &Path) {
    let mut git = Command::new("git");
    git.args([
        "ls-files",
        "-z",
        "Cargo.toml",
        "Cargo.lock",
        "clippy.toml",
        "hal",
        "components",
        "halcmd",
        "tests/Cargo.toml",
        "tests/src",
        "configs/printer",
    ]);
    let listed = git.current_dir(root()).stdin(Stdio::null()).output().unwrap();
    assert!(listed.status.success(), "git: {}", String::from_utf8_lossy(&listed.stderr));
    let listed = String::from_utf8(listed.stdout).unwrap();
    for name in listed.split('\0').filter(|name| !name.is_empty()) {
        let (from, to) = (root().join(name), to.join(name));
        // A file that was removed and not yet committed is in the list.
        if from.is_file() {
            fs::create_dir_all(to.parent().unwrap()).unwrap();
            fs::copy(from, to).unwrap();
        }
    }
}

#[test]
fn a_first_crate_builds_and_its_component_runs() {
    let page = fs::read_to_string(root().join("components/README.md")).unwrap();
    let code = block(&page, "## Write one", "rust").split("\n// Its test").next().unwrap();
    let manifest = block(&page, "### The crate", "toml");
    let scratch = Scratch::new("recipe");
    let tree = scratch.path().join("tree");
    copy_tree(&tree);
    // The tests' own programs and benches are not part of the copy.
    let of_tests = fs::read_to_string(tree.join("tests/Cargo.toml")).unwrap();
    let of_tests: Vec<&str> = of_tests.split("\n[[bench]]").collect();
    let end = of_tests.last().unwrap().split_once("\n[lints]").unwrap().1;
    fs::write(
        tree.join("tests/Cargo.toml"),
        format!("{}\n[lints]{end}", of_tests.first().unwrap()),
    )
    .unwrap();
    let ramp = tree.join("components/blocks/ramp");
    fs::create_dir_all(ramp.join("src")).unwrap();
    fs::write(ramp.join("Cargo.toml"), manifest).unwrap();
    let text = format!("//! A ramp.\n#![forbid(unsafe_code)]\n\n{code}\n");
    fs::write(ramp.join("src/lib.rs"), text).unwrap();
    let mut build = cargo("build");
    let words = ["--package", "ramp", "--offline", "--quiet"];
    let built = build
        .args(words)
        .current_dir(&tree)
        .env("CARGO_TARGET_DIR", tree.join("target"))
        .output()
        .unwrap();
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));

    scratch.write(
        "m.hal",
        "loadrt threads name1=t period1=1000000\nloadrt ramp\naddf ramp.0 t\nsetp ramp.0.max-speed 100\n\
         setp ramp.0.in 0.15\nstart\nrun 1ms\ngetp ramp.0.out\nrun 1ms\ngetp ramp.0.out\n",
    );
    let mut halrun = scratch.command(&[], "halrun");
    halrun
        .args(["--virtual", "--hold", "-f", "m.hal"])
        .env("HAL_RTMOD_DIR", tree.join("target/debug"));
    let output = scratch.run(&mut halrun);
    assert_eq!(
        (output.stdout.as_str(), output.stderr.as_str()),
        ("0.1\n0.15\n", ""),
        "{:?}",
        programs()
    );
    assert_eq!(output.status, Some(0));
}
