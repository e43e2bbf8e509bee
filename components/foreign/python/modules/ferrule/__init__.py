"""Machines in tests and notebooks: an instance on the virtual clock, its pins, and pictures of their waveforms.

    from ferrule import Machine

    with Machine("lift.hal") as machine:
        machine.up = True
        with machine.record("height", "up") as capture:
            machine.run("2s")
        assert capture["height"].last > 0.5
        capture                     # a picture in a notebook

With pytest, ferrule.plugin makes the fixture `machine`."""

from .capture import Capture, Wave
from .machine import Machine, Refused

__all__ = ["Capture", "Machine", "Refused", "Wave"]
