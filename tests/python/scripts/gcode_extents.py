"""Extents of previews."""
import gcode

ZERO = (0.0,) * 9
TO = (1.0, -2.0, 3.0, 10.0, 0.0, 0.0, 4.0, 0.0, 0.0)
LINES = [
    [],
    [(1, ZERO, TO, (0.0, 0.0, 0.0))],
    [(1, ZERO, TO, 5.0, (0.5, -0.5, 1.0))],
    [(1, TO, TO, (0.0, 0.0, 2.0)), (2, ZERO, ZERO, (0.0, 0.0, -2.0))],
]
for lines in LINES:
    print(gcode.calc_extents(lines))
print(gcode.calc_extents(LINES[1], LINES[2], LINES[3]))
print(gcode.calc_extents())
print(gcode.MIN_ERROR, gcode.MAX_ERROR)
