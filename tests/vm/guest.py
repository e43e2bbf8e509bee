"""The guest's first file system: BusyBox, the kernel's modules, Ferrule's release binaries, the machines."""

import os
import pathlib
import re
import shutil
import subprocess

import kernels

# Programs of the host, each with the package of Debian that has it.
TOOLS = {
    "qemu-system-x86_64": "qemu-system-x86",
    "busybox": "busybox-static",
    "cpio": "cpio",
    "setpriv": "util-linux",
    "setcap": "libcap2-bin",
    "strip": "binutils",
    "dpkg": "dpkg",
}
PROGRAMS = ("halrun", "halcmd", "hal_manualtoolchange")
# Programs of the host that the guest has besides, which BusyBox lacks or has in part.
HOST_PROGRAMS = ("setpriv", "setcap")
PLUGINS = ("threads", "parport", "stepgen", "timing", "signal", "motion", "trivkins", "task", "toolchange")
HERE = pathlib.Path(__file__).resolve().parent
MACHINES = ("steps.hal", "ends.hal", "wakeups.hal", "user.hal", "ends.table")


def missing(root):
    """Returns a line for each thing that is not there, with the command that brings it."""
    lines = [f"{tool}: apt-get install {package}" for tool, package in TOOLS.items() if not found(tool)]
    if not lines and libraries(found("busybox")):
        lines.append("a BusyBox without shared libraries: apt-get install busybox-static")
    release = kernels.target(root) / "release"
    files = [*PROGRAMS, *(f"lib{name}.so" for name in PLUGINS)]
    absent = [name for name in files if not (release / name).exists()]
    if absent:
        lines.append(f"{', '.join(absent)} in {release}: cargo build --release --locked")
    return lines


def found(tool):
    """Returns the path of a program; some are where only root looks."""
    return shutil.which(tool, path=f"{os.environ.get('PATH', '')}:/usr/sbin:/sbin")


# The printer of the documents has its two lines on a parallel port here, and runs on the real clock.
PRINTER = "configs/printer"
CHANGES = {
    "printer.hal": [
        (r"loadrt hal_viagpio", "loadrt hal_parport cfg=378"),
        (r"addf viagpio\.(read|write) ", r"addf parport.0.\1 "),
        (r"viagpio\.pin-05-out", "parport.0.pin-03-out"),
        (r"viagpio\.pin-06-out", "parport.0.pin-02-out"),
    ],
    "scope.hal": [
        (r"record scope\.vcd .*", "record $(OUT)/printer.vcd xstep xdir"),
        (r"run (\d+)ms", r"loadusr -w usleep \g<1>000"),
    ],
}


def printer(root, place):
    """Puts the printer's files into a folder, with the changes."""
    for source in sorted((root / PRINTER).iterdir()):
        if source.suffix not in (".hal", ".ini", ".tbl"):
            continue
        text = source.read_text()
        for before, after in CHANGES.get(source.name, []):
            text, number = re.subn(before, after, text)
            if not number:
                raise ValueError(f"{source} has no {before}")
        (place / source.name).parent.mkdir(parents=True, exist_ok=True)
        (place / source.name).write_text(text)


def libraries(program):
    """Returns the shared libraries of a program or a plugin."""
    said = subprocess.run(["ldd", str(program)], capture_output=True, text=True, check=False).stdout
    return re.findall(r"(/\S+) \(0x", said)


def faulty(root):
    """Builds the plugin whose components fail on purpose."""
    folder = kernels.target(root) / "test-plugins"
    subprocess.run(
        ["cargo", "build", "--locked", "--quiet", "--workspace", "--manifest-path", "tests/plugins/Cargo.toml"]
        + ["--target-dir", str(folder)],
        cwd=root,
        env={**os.environ, "CARGO_INCREMENTAL": "0"},
        check=True,
    )
    return folder / "debug/libfaulty.so"


def initramfs(root, folder, kernel):
    """Makes the archive with which a kernel boots, and returns its path."""
    tree = folder / "tree"
    shutil.rmtree(tree, ignore_errors=True)
    release = kernels.target(root) / "release"
    put(found("busybox"), tree / "bin/busybox")
    for name in PROGRAMS:
        stripped(release / name, tree / "ferrule" / name)
    for plugin in [*(release / f"lib{name}.so" for name in PLUGINS), faulty(root)]:
        stripped(plugin, tree / "ferrule/lib" / plugin.name)
    for name in HOST_PROGRAMS:
        put(found(name), tree / "ferrule" / name)
    needed = {library for name in [*PROGRAMS, *HOST_PROGRAMS] for library in libraries(tree / "ferrule" / name)}
    for library in sorted(needed):
        put(library, tree / library.lstrip("/"))
    for module in kernel.modules:
        put(module, tree / "lib/modules" / module.name)
    for name in MACHINES:
        put(HERE / name, tree / "vm" / name)
    put(HERE / "init", tree / "init")
    printer(root, tree / "vm/printer")
    names = "".join(f"{path.relative_to(tree)}\0" for path in sorted(tree.rglob("*")))
    # The same files make the same archive: otherwise two boots could differ.
    for path in [tree, *tree.rglob("*")]:
        os.utime(path, (0, 0), follow_symlinks=False)
    archive = folder / f"{kernel.package}.cpio"
    with archive.open("wb") as out:
        words = ["cpio", "--null", "--create", "--format=newc", "--quiet", "--reproducible", "--owner=0:0"]
        subprocess.run(words, cwd=tree, input=names.encode(), stdout=out, check=True)
    return archive


def put(source, place):
    place.parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(source, place)


def stripped(source, place):
    put(source, place)
    subprocess.run(["strip", "--strip-debug", str(place)], check=True)
