"""Debian's newest kernels of the series 6.1: found in the package lists, downloaded, and unpacked without installing."""

import dataclasses
import lzma
import os
import pathlib
import re
import shutil
import subprocess

KINDS = ("usual", "rt")
SERIES = "6.1"
MODULES = (
    "drivers/parport/parport.ko",
    "drivers/parport/parport_pc.ko",
    "drivers/char/ppdev.ko",
)


@dataclasses.dataclass
class Kernel:
    package: str
    image: pathlib.Path
    modules: list


def target(root):
    """Returns the folder of cargo's output."""
    return pathlib.Path(os.environ.get("CARGO_TARGET_DIR", root / "target"))


def newest(kind):
    """Returns the name of the newest package of a kernel, or None if no package list has one."""
    name = rf"linux-image-{re.escape(SERIES)}\.0-(\d+)-{'rt-' if kind == 'rt' else ''}amd64"
    listed = subprocess.run(
        ["apt-cache", "pkgnames", f"linux-image-{SERIES}"], capture_output=True, text=True, check=False
    ).stdout.split()
    found = [(int(match[1]), match[0]) for match in map(re.compile(name).fullmatch, listed) if match]
    return max(found)[1] if found else None


def missing():
    """Returns a line for each kernel that cannot be had."""
    if not shutil.which("apt-cache"):
        return ["apt-cache: the kernels are packages of Debian 12"]
    return [
        f"a kernel {SERIES} ({kind}) in the package lists: apt-get update, on Debian 12"
        for kind in KINDS
        if not newest(kind)
    ]


def get(folder, kind):
    """Returns a kernel, downloaded and unpacked if it is not there yet."""
    package = newest(kind)
    place = folder / package
    if not (place / "done").exists():
        shutil.rmtree(place, ignore_errors=True)
        place.mkdir(parents=True)
        subprocess.run(["apt-get", "download", "-qq", package], cwd=place, check=True)
        (file,) = place.glob("*.deb")
        subprocess.run(["dpkg", "-x", str(file), str(place / "whole")], check=True)
        for kept in [*place.glob("whole/boot/vmlinuz-*"), *(find(place, m) for m in MODULES)]:
            shutil.copy(kept, place)
        shutil.rmtree(place / "whole")
        file.unlink()
        (place / "done").touch()
    return Kernel(package, unpacked(place), [place / pathlib.Path(m).name for m in MODULES])


def unpacked(place):
    """Returns the path of the kernel's program, which the guest would else unpack for seconds in each boot."""
    (packed,) = place.glob("vmlinuz-*")
    program = place / "vmlinux"
    if program.exists():
        return program
    content = packed.read_bytes()
    for at in (match.start() for match in re.finditer(re.escape(b"\xfd7zXZ\0"), content)):
        try:
            found = lzma.LZMADecompressor(format=lzma.FORMAT_XZ).decompress(content[at:])
        except lzma.LZMAError:
            continue
        if found.startswith(b"\x7fELF"):
            program.write_bytes(found)
            return program
    return packed


def find(place, module):
    (file,) = place.glob(f"whole/lib/modules/*/kernel/{module}")
    return file
