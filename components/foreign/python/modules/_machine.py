"""State and commands of a machine: a module of Ferrule's library."""

import _hal_library

_hal_library.become(__name__)
