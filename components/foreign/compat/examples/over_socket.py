"""Asks a running instance through its socket: a line of JSON for each request, and a line for its answer.

    halrun -b machine.hal
    python3 over_socket.py sum
"""
import json, os, socket, sys


def path(instance):
    """Returns the socket of an instance of this user. The README of the folder lists the places."""
    env, user = os.environ, os.getuid()
    given, usual = env.get("HAL_RUNTIME_DIR"), (env.get("XDG_RUNTIME_DIR"), "/run/user/%d" % user, "/run")
    places = ["%s/ferrule" % folder for folder in ([given] if given else usual) if folder]
    places.append("%s/ferrule-%d" % (env.get("TMPDIR", "/tmp"), user))
    sockets = ["%s/%s.sock" % (place, instance) for place in places]
    return next((s for s in sockets if os.path.exists(s) and os.stat(s).st_uid == user), sockets[0])


class Client:
    def __init__(self, instance=os.environ.get("HAL_INSTANCE", "default")):
        self.socket = socket.socket(socket.AF_UNIX)
        self.socket.connect(path(instance))
        self.lines = self.socket.makefile("r", encoding="utf-8")
        self.ask({"hello": {"protocol": 1, "name": "", "pid": os.getpid()}})

    def ask(self, request):
        self.socket.sendall(json.dumps({"request": request}).encode() + b"\n")
        answer = json.loads(self.lines.readline())
        if "error" in answer:
            raise RuntimeError(answer["error"]["text"])
        return answer["ok"]


client, name = Client(), sys.argv[1]
print(name, client.ask({"get-signal": {"name": name}}))
client.ask({"set-signal": {"name": name, "value": "2.5"}})
print(name, client.ask({"get-signal": {"name": name}}))
try:
    client.ask({"get": {"name": "no-such-name"}})
except RuntimeError as why:
    print(why)
