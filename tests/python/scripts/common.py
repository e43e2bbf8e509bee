"""What the scripts share: each line of output says what a call returned or raised."""

import time

import hal

IN, OUT, IO, RO, RW = hal.HAL_IN, hal.HAL_OUT, hal.HAL_IO, hal.HAL_RO, hal.HAL_RW
BIT, FLOAT, S32, U32 = hal.HAL_BIT, hal.HAL_FLOAT, hal.HAL_S32, hal.HAL_U32


def show(label, call):
    try:
        print(label, "->", repr(call()), flush=True)
    except TypeError:
        # The words are those of the tool that made the module.
        print(label, "!! TypeError", flush=True)
    except BaseException as e:
        print(label, "!!", type(e).__module__, type(e).__name__, e, flush=True)


def settle():
    """Waits until the machine and this program have exchanged their values."""
    time.sleep(0.05)
