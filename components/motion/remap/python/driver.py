"""Runs functions of remaps and O-words for the interpreter, which speaks through standard input and output.

Each message is a line of JSON. The interpreter sends its state; the answer has the effects of the function until it
waits for something, and what that is."""

import inspect
import json
import os
import queue
import sys
import threading
import traceback

view = {"fields": {}, "numbered": {}, "locals": {}, "globals": {}, "blocks": [], "speed": [], "turning": [],
        "tool_offset": {}, "g_codes": [0] * 13, "file": ""}
tools = {}
_effects = []
_messages = queue.SimpleQueue()
_answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
_serial = None
_closed = False
# A message for a call around the innermost one.
_outer = None
_remap = None
_oword = None


def _listen():
    for line in sys.stdin.buffer:
        _messages.put(json.loads(line))
    _messages.put(None)
    # Whatever still runs ends with the interpreter.
    threading.Event().wait(1.0)
    os._exit(0)


def _send(message):
    _answers.write(json.dumps(message, allow_nan=False) + "\n")
    _answers.flush()


def _take(message):
    global _serial
    message["numbered"] = dict(map(tuple, message["numbered"]))
    view.clear()
    view.update(message)
    _serial = message["function"]["serial"]


def effect(kind, *words):
    if _serial is None:
        raise RuntimeError("no program runs")
    # What cannot be sent fails at the line that makes it.
    json.dumps(words, allow_nan=False)
    _effects.append({kind: list(words)})


def _ask(request):
    """Sends what the function has done and what it waits for, and returns what it gets."""
    global _effects, _closed, _outer
    mine = _serial
    if mine is None:
        raise RuntimeError("no program runs")
    if _outer is not None:
        raise _Left
    done, _effects = _effects, []
    _send({"effects": done, "next": request})
    while True:
        message, _outer = _outer or _messages.get(), None
        if message is None:
            _closed = True
            raise SystemExit
        if message["function"]["serial"] == mine:
            _take(message)
            return message["function"]["turn"]
        if message["function"]["turn"] != "Begin":
            _outer = message
            raise _Left
        # A line that this function executes calls another one.
        _run(message)


def execute(line):
    return _ask({"Execute": line})["Executed"]


def named(name):
    for names in (view["locals"], view["globals"]):
        if name in names:
            return names[name]
    value = _ask({"Ask": {"Name": name}})["Value"]
    if value is None:
        raise RuntimeError("parameter does not exist: " + name)
    return value


def slot(number):
    value = _ask({"Ask": {"Slot": number}})["Value"]
    if value is None:
        return None
    tools[int(value)] = number
    return int(value)


def refresh():
    _ask({"Ask": {"Name": "_line"}})


class _Left(BaseException):
    """A call around this one goes on, because this one has failed."""


class _Failed(Exception):
    """A function that says that it has failed."""


def _settle(status, is_word):
    """Follows what a function returns or yields. Returns whether it goes on, and the value of an O-word."""
    from interpreter import InterpReturn, this
    if status is None:
        return False, None
    if isinstance(status, str):
        raise _Failed(status)
    if isinstance(status, float) and is_word:
        return False, status
    if isinstance(status, bool) or not isinstance(status, int):
        raise _Failed("it returned %r, not INTERP_OK, INTERP_ERROR or a text" % (status,))
    if status == InterpReturn.INTERP_EXECUTE_FINISH:
        _ask("Finish")
        return True, None
    if status >= InterpReturn.INTERP_ENDFILE:
        raise _Failed(this.get_errormsg() or "it returned %d" % status)
    return False, None


def _call(function, arguments, words, is_word):
    from interpreter import this
    this.set_errormsg("")
    result = function(this, *arguments, **words)
    if not inspect.isgenerator(result):
        return _settle(result, is_word)[1]
    for status in result:
        goes_on, value = _settle(status, is_word)
        if not goes_on:
            return value
    return None


def _place(error):
    """Returns the user's file and line of an error."""
    for frame in reversed(traceback.extract_tb(error.__traceback__)):
        if not frame.filename.startswith("<ferrule"):
            return "%s:%d: " % (os.path.basename(frame.filename), frame.lineno)
    return ""


def _told(error):
    return "%s%s: %s" % (_place(error), type(error).__name__, error)


def _run(message):
    """Runs a function to its end."""
    global _effects, _serial
    outer = _serial
    _take(message)
    called = message["function"]
    is_word = called["hook"] == "Word"
    module = _oword if is_word else _remap
    function = getattr(module, called["name"], None)
    _effects = []
    try:
        if not callable(function):
            raise _Failed("there is no such function in %s.py" % ("oword" if is_word else "remap"))
        end = {"Done": _call(function, called["arguments"], dict(map(tuple, called["words"])), is_word)}
    except _Failed as failed:
        end = {"Fail": str(failed)}
    except Exception as error:
        traceback.print_exc()
        end = {"Fail": _told(error)}
    except SystemExit:
        if _closed:
            raise
        end = {"Fail": "it ended its process"}
    except _Left:
        end = None
    done, _effects = _effects, []
    _serial = outer
    if _outer is not None:
        return
    _send({"effects": done, "next": end})


def _functions(module):
    names = vars(module) if module else {}
    return sorted(name for name, value in names.items() if callable(value) and not name.startswith("__"))


def _load(settings):
    """Runs the user's top level, or imports the modules remap and oword where there is none."""
    global _remap, _oword
    sys.path[:0] = settings["prepend"]
    sys.path.extend(settings["append"])
    view["fields"]["task"] = settings["task"]
    names = {"__name__": "toplevel", "__file__": settings["toplevel"]}
    if settings["toplevel"]:
        with open(settings["toplevel"], encoding="utf-8") as file:
            exec(compile(file.read(), settings["toplevel"], "exec"), names)
    else:
        for name in ("remap", "oword"):
            try:
                names[name] = __import__(name)
            except ModuleNotFoundError as missing:
                if missing.name != name:
                    raise
    _remap, _oword = names.get("remap"), names.get("oword")
    return names


def main():
    # What functions print goes beside the messages of the program.
    os.dup2(2, 1)
    sys.stdout.reconfigure(line_buffering=True)
    threading.Thread(target=_listen, daemon=True).start()
    from interpreter import this
    names = {}
    try:
        names = _load(_messages.get())
        if "__init__" in names:
            names["__init__"](this)
        _send({"words": _functions(_oword), "error": None})
    except Exception as error:
        traceback.print_exc()
        _send({"words": [], "error": _told(error)})
    while True:
        message = _messages.get()
        if message is None:
            break
        _run(message)
    if "__delete__" in names:
        names["__delete__"](this)
