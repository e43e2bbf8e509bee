"""State and commands of a machine: a module of the library of `_hal`."""

import _hal_library

_hal_library.become(__name__)
