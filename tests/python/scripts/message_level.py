from common import *

h = hal.component("c")
h.ready()
show("get", hal.get_msg_level)
for level in hal.MSG_NONE, hal.MSG_ALL, hal.MSG_ERR:
    show("set", lambda: hal.set_msg_level(level))
    show("get", hal.get_msg_level)
show("text", lambda: hal.set_msg_level("x"))
