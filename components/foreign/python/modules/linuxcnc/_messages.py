"""Messages for the operator."""

import _machine

from ._constants import OPERATOR_DISPLAY, OPERATOR_ERROR
from ._pages import Blank, is_stale, page, task_page

#: Messages of this program: refused commands, and what it has the operator told.
own = []
#: Largest number of messages that wait; the oldest ones give way.
MAX_WAITING = 100
#: Commands in progress whose failure nobody has seen yet: (channel, ticket). As many wait as messages do.
pending = []


def add(kind, text):
    """Adds a message of this program."""
    own.append((kind, text))
    del own[:-MAX_WAITING]


def follow(entry):
    """Notes a command in progress."""
    pending.append(entry)
    if len(pending) > MAX_WAITING:
        collect()
        del pending[:-MAX_WAITING]


def fail(why):
    """Adds the reason why a command failed. A jog or stop that gave way to the next one is no failure for an operator."""
    if not why.startswith("superseded by "):
        add(OPERATOR_ERROR, why)


def collect():
    """Turns failures of commands that have ended into messages."""
    for entry in list(pending):
        channel, ticket = entry
        try:
            why = channel.ticket(ticket)
        except _machine.error:
            why = ""
        if why is not None and entry in pending:
            pending.remove(entry)
            if why:
                fail(why)


class error_channel:
    """Messages of the machine since this object was made, and those of this program that nobody has read.

    The machine shows its last message only: of several between two calls of `poll`, the last is returned, then the number of
    the others.
    """

    def __init__(self):
        self._channel = None
        self._page = None
        self._seen = 0
        self._last = None
        try:
            self._open()
        except _machine.error:
            pass

    def _open(self):
        if self._channel is None:
            self._channel = _machine.Channel()
        # Of a task that is not there yet, no message is old.
        was_blank = isinstance(self._page, Blank)
        self._page = task_page(self._channel, page(self._channel, "motion.status"))
        self._seen = 0 if was_blank else self._page["messages"]

    def poll(self):
        """Returns the oldest message that was not returned yet as (kind, text), or None."""
        if is_stale(self._page):
            self._open()
        self._page.poll()
        collect()
        count = self._page["messages"]
        if count != self._seen:
            lost = count - self._seen - 1
            self._seen = count
            text = self._page.text("message")
            failed = self._page["message_level"] > 0 if "message_level" in self._page else True
            # The failure of a job is also that of the command that began it.
            own[:] = [m for m in own if m[1] != text]
            # A machine that began anew counts anew.
            if lost > 0:
                add(OPERATOR_DISPLAY, "%d more messages came too fast to be shown" % lost)
            return OPERATOR_ERROR if failed else OPERATOR_DISPLAY, text
        return own.pop(0) if own else None
