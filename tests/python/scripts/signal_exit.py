#: loadrt threads name1=servo period1=1000000
#: start
from common import *
import signal

class Done(Exception):
    pass

def ended(*_):
    h.exit()
    raise Done("in the handler")

h = hal.component("c")
h.newpin("a", S32, OUT)
h.ready()
signal.signal(signal.SIGALRM, ended)
signal.setitimer(signal.ITIMER_REAL, 0.1)
show("sleep", lambda: time.sleep(1e9))
show("after", lambda: h["a"])
show("again", lambda: h.exit())
