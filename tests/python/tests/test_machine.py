"""Tests of a machine with pytest."""

import pytest

pytestmark = pytest.mark.machine("machine.hal")


def test_pins_are_attributes(machine):
    machine.and2_0_in0 = True
    machine.and2_0_in1 = True
    assert machine.and2_0_out is False
    machine.run("1ms")
    assert machine.and2_0_out is True


def test_a_waveform_is_that_of_the_file(machine):
    with machine.record("wave") as capture:
        machine.run(0.02)
    assert capture["wave"].last == pytest.approx(0.2487, abs=1e-3)
    capture.compare(__file__.replace("test_machine.py", "wave.txt"))
