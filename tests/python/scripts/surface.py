"""Prints each public name of the modules, with its kind, value or members."""
import _hal
import gcode
import hal
import linuxcnc

for module in hal, _hal, linuxcnc, gcode:
    private = "_" if module in (linuxcnc, gcode) else "__"
    for name in sorted(n for n in dir(module) if not n.startswith(private)):
        thing = getattr(module, name)
        label = f"{module.__name__}.{name}"
        if isinstance(thing, type) and issubclass(thing, BaseException):
            print(label, "exception")
        elif isinstance(thing, type):
            print(label, "class")
            for member in sorted(set(dir(thing)) - set(dir(object))):
                if member not in ("__dict__", "__module__", "__weakref__") and not (
                    private == "_" and member.startswith("_")
                ):
                    print(f"{label}.{member}", "method" if callable(getattr(thing, member)) else "property")
        elif callable(thing):
            print(label, "function")
        elif type(thing).__name__ == "module":
            print(label, "module")
        else:
            print(label, repr(thing))
