"""Machines in tests and notebooks: an instance on the virtual clock, its pins, and pictures of their waveforms.

    from ferrule import Machine

    with Machine("lift.hal") as machine:
        machine.up = True
        with machine.record("height", "up") as capture:
            machine.run("2s")
        assert capture["height"].last > 0.5
        capture                     # a picture in a notebook

With pytest, ferrule.plugin makes the fixture `machine`."""

import importlib

_MODULES = {"Capture": "capture", "Wave": "capture", "Machine": "machine", "Refused": "machine"}
__all__ = sorted(_MODULES)


def __getattr__(name):
    # Programs that need `hal` alone import nothing of this.
    if name not in _MODULES:
        raise AttributeError("module 'ferrule' has no attribute '%s'" % name)
    return getattr(importlib.import_module("ferrule." + _MODULES[name]), name)
