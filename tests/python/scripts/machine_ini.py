"""INI files."""
import linuxcnc

with open("m.ini", "w") as file:
    file.write(
        "[TRAJ]\n"
        "COORDINATES = X Y Z\n"
        "LINEAR_UNITS=mm\n"
        "# REMARK = 1\n"
        "; REMARK = 2\n"
        "[HAL]\n"
        "HALFILE = a.hal\n"
        "HALFILE = b.hal with words\n"
        "EMPTY =\n"
        "[traj]\n"
        "OTHER = 1\n"
    )
ini = linuxcnc.ini("m.ini")
for section, option in (
    ("TRAJ", "COORDINATES"),
    ("TRAJ", "LINEAR_UNITS"),
    ("TRAJ", "linear_units"),
    ("TRAJ", "REMARK"),
    ("HAL", "HALFILE"),
    ("HAL", "MISSING"),
    ("NONE", "HALFILE"),
    ("traj", "OTHER"),
):
    print(section, option, repr(ini.find(section, option)), ini.findall(section, option))
try:
    linuxcnc.ini("missing.ini")
except linuxcnc.error as e:
    print("error", type(e).__name__, isinstance(e, RuntimeError))
for call in (lambda: ini.find("TRAJ"), lambda: linuxcnc.ini()):
    try:
        call()
    except TypeError as e:
        print("TypeError")
