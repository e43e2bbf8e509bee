from common import *

for name in sorted(n for n in dir(hal) if n.startswith(("HAL_", "MSG_", "is_", "sampler", "streamer", "kernel"))):
    if name not in ("HAL_S64", "HAL_U64"):
        print(name, repr(getattr(hal, name)))
