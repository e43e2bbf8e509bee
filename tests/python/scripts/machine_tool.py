"""Rows of tool tables, and the constants that programs count with."""
import linuxcnc

print(linuxcnc.error.__mro__)
for name in sorted(n for n in dir(linuxcnc) if n.isupper() and isinstance(getattr(linuxcnc, n), int)):
    print(name, getattr(linuxcnc, name))
