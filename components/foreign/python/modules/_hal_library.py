"""The library with the modules `_hal`, `_machine` and `gcode`."""

import importlib.machinery
import importlib.util
import pathlib
import sys

import ferrule

_FILE = str(pathlib.Path(ferrule.__file__).with_name("_library.abi3.so"))


def become(name):
    """Puts the library's module of this name in the place of the one that asks."""
    loader = importlib.machinery.ExtensionFileLoader(name, _FILE)
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(name, loader))
    sys.modules[name] = module
    loader.exec_module(module)
