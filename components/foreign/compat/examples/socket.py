"""Asks a running instance through its socket: a line of JSON for each request, and a line for its answer.

    halrun -b machine.hal
    python3 socket.py sum

Any language with Unix sockets and JSON does it in the same way."""

import json
import os
import socket
import sys


def path(instance):
    """Returns the socket of an instance. The README of the folder lists the places."""
    user = os.getuid()
    if os.environ.get("HAL_RUNTIME_DIR"):
        return os.path.join(os.environ["HAL_RUNTIME_DIR"], "ferrule", instance + ".sock")
    for folder in (os.environ.get("XDG_RUNTIME_DIR"), "/run/user/%d" % user, "/run" if user == 0 else None):
        if folder and os.path.isdir(folder) and os.stat(folder).st_uid == user:
            return os.path.join(folder, "ferrule", instance + ".sock")
    return os.path.join(os.environ.get("TMPDIR", "/tmp"), "ferrule-%d" % user, instance + ".sock")


class Client:
    def __init__(self, instance=None):
        self.socket = socket.socket(socket.AF_UNIX)
        self.socket.connect(path(instance or os.environ.get("HAL_INSTANCE") or "default"))
        self.lines = self.socket.makefile("r", encoding="utf-8")
        self.ask({"hello": {"protocol": 1, "name": "", "pid": os.getpid()}})

    def ask(self, request):
        self.socket.sendall(json.dumps({"request": request}).encode() + b"\n")
        answer = json.loads(self.lines.readline())
        if "error" in answer:
            raise RuntimeError(answer["error"]["text"])
        return answer["ok"]


if __name__ == "__main__":
    name = sys.argv[1] if len(sys.argv) > 1 else "sum"
    client = Client()
    print(name, client.ask({"get-signal": {"name": name}}))
    client.ask({"set-signal": {"name": name, "value": "2.5"}})
    print(name, client.ask({"get-signal": {"name": name}}))
    try:
        client.ask({"get": {"name": "no-such-name"}})
    except RuntimeError as why:
        print(why)
