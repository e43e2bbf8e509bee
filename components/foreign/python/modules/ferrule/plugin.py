"""The pytest plugin: a machine for each test.

Switch it on with `pytest -p ferrule.plugin`, or by `pytest_plugins = ["ferrule.plugin"]` in conftest.py; an installed
wheel does it by itself. A test names its file with a mark, or the project with `machine = FILE` in pytest.ini:

    import pytest

    @pytest.mark.machine("lift.hal")
    def test_lift(machine):
        machine.up = True
        machine.run("2s")
        assert machine.height > 0.5
"""

import pathlib

import pytest

from .machine import Machine


def pytest_addoption(parser):
    parser.addini("machine", "HAL or INI file of the fixture 'machine'", default="")


def pytest_configure(config):
    config.addinivalue_line("markers", "machine(file, *words): HAL or INI file of the fixture 'machine', options of halrun")


@pytest.fixture
def machine(request):
    """A machine on the virtual clock, which moves in machine.run() alone."""
    mark = request.node.get_closest_marker("machine")
    if mark is not None and mark.args:
        file, words = pathlib.Path(request.node.path).parent / mark.args[0], mark.args[1:]
    elif request.config.getini("machine"):
        file, words = pathlib.Path(request.config.rootpath) / request.config.getini("machine"), ()
    else:
        pytest.fail("the test has no machine: @pytest.mark.machine(\"FILE\"), or 'machine = FILE' in pytest.ini")
    with Machine(file, *words) as running:
        yield running
