from common import *

print(hal.error.__name__, hal.error.__module__, [c.__name__ for c in hal.error.__mro__])
try:
    raise hal.error("text")
except Exception as e:
    print(type(e).__name__, e, e.args)
