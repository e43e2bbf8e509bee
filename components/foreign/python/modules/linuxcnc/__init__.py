"""State and commands of a machine, with the names that programs written for LinuxCNC expect.

    import linuxcnc
    stat, command = linuxcnc.stat(), linuxcnc.command()
    stat.poll()
    print(stat.task_state == linuxcnc.STATE_ON, stat.position)
    command.mode(linuxcnc.MODE_MDI)
    command.mdi("G0 X10")
    command.wait_complete()
"""

import os as _os

from _machine import error, ini

from ._command import command
from ._constants import *
from ._drawing import (
    draw_dwells,
    draw_lines,
    gui_respect_offsets,
    gui_rot_offsets,
    line9,
    vertex9,
)
from ._files import tool
from ._logger import positionlogger
from ._messages import error_channel
from ._stat import stat

#: Folders of the programs around a machine: interfaces, pictures, samples.
PREFIX = _os.environ.get("LINUXCNC_HOME", "/usr")
SHARE = _os.path.join(PREFIX, "share")
#: File that programs check for before they look for a machine.
nmlfile = _os.path.join(_os.path.dirname(__file__), "linuxcnc.nml")
version = "2.9"
