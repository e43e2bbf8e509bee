import oword
import remap


def __init__(self):
    remap.calls = 0
    self.mark = "kept"
