"""Programs as canonical calls, in inches, and the results of programs that fail."""
import gcode

NAMES = """straight_traverse straight_feed arc_feed set_g5x_offset set_g92_offset set_xy_rotation set_plane
set_feed_rate comment message dwell change_tool tool_offset rigid_tap straight_probe
user_defined_function""".split()
TOOLS = [(-1,) + (0.0,) * 12 + (0,), (7, 0.0, 0.0, 1.5) + (0.0,) * 6 + (0.25, 0.0, 0.0, 0)]
PROGRAMS = {
    "lines": "(a remark)\n(MSG, hello)\nG21\nG0 X25.4 Y50.8\nG1 Z-2.54 F254\nG91 G1 X25.4\nM2\n",
    "offsets": "G10 L2 P1 X1 Y2 R30\nG54 G0 X1\nG92 X3\nG0 X4\nM2\n",
    "rotary": "G1 X1 A90 B45 C-30 F10\nG93 G1 X2 F3\nM2\n",
    "helix": "G0 X1\nG3 X-1 Y0 I-1 J0 Z1 F20\nG2 X1 Y0 I1 J0 P3\nM2\n",
    "planes": "G18 G2 X1 Z1 I1 K0 F5\nG19 G3 Y1 Z2 J1 K0\nM2\n",
    "cycle": "G0 Z1\nG81 X1 Y1 Z-0.5 R0.5 F10\nX2\nG80\nM2\n",
    "dwell": "G4 P0.25\nM2\n",
    "subroutine": "o1 sub\nG1 X#1 F10\no1 endsub\no1 call [2]\no1 call [3]\nM2\n",
    "skipped": "/G0 X9\nG0 X1\nM2\n",
    "no end": "G0 X1\n",
    "bad word": "G0 X1\nG1 X\nM2\n",
    "bad arc": "G2 X1 Y1 I5 J0 F10\nM2\n",
    "unknown": "G0 X1\nG99999\n",
    "divided": "G0 X[1/0]\n",
}


class Canon:
    parameter_file = "parameters.var"

    def next_line(self, state):
        self.line = state.sequence_number

    def get_tool(self, index):
        return TOOLS[index] if index < len(TOOLS) else TOOLS[0]

    def get_external_length_units(self):
        return 1 / 25.4

    def get_external_angular_units(self):
        return 1.0

    def get_axis_mask(self):
        return 63

    def get_block_delete(self):
        return True

    def check_abort(self):
        return False

    def is_lathe(self):
        return False


def shown(value):
    return f"{value + 0.0:.5f}" if isinstance(value, float) else repr(value)


def teller(name):
    def tell(self, *args):
        print(" ", name, *map(shown, args))

    return tell


for name in NAMES:
    setattr(Canon, name, teller(name))

with open("parameters.var", "w") as file:
    file.write("5161 0.0\n5162 0.0\n5163 0.0\n5220 1\n5221 0\n5222 0\n5223 0\n")

for title, text in PROGRAMS.items():
    with open("program.ngc", "w") as file:
        file.write(text)
    print(title, flush=True)
    result, line = gcode.parse("program.ngc", Canon(), "G20")
    failed = result > gcode.MIN_ERROR
    print("  result", result, line, gcode.strerror(result) if failed else "", flush=True)

print("no file", gcode.parse("missing.ngc", Canon(), "G20"))
