"""Drawing of previews with OpenGL. PyOpenGL is imported when something is drawn."""

import _machine
from _machine import gui_respect_offsets, gui_rot_offsets, vertex9

#: Half the size of the mark of a dwell, in inches.
DWELL_SIZE = 0.015625
_FLOAT_BYTES = 4


def _gl():
    from OpenGL import GL

    return GL


def line9(geometry, start, end):
    """line9(GEOMETRY, START, END): draws a line between places of nine axes, after glBegin(GL_LINES)."""
    gl = _gl()
    for point in _machine.pieces(geometry, start, end):
        gl.glVertex3d(*point)


def draw_lines(geometry, lines, for_selection=0):
    """draw_lines(GEOMETRY, LINES[, FOR_SELECTION]): draws lines (number, start, end, …)."""
    points, runs = _machine.vertices(geometry, lines)
    if not points:
        return
    gl = _gl()
    gl.glPushClientAttrib(gl.GL_CLIENT_VERTEX_ARRAY_BIT)
    gl.glEnableClientState(gl.GL_VERTEX_ARRAY)
    gl.glVertexPointer(3, gl.GL_FLOAT, 0, points)
    if for_selection:
        for number, first, count in runs:
            gl.glLoadName(number)
            gl.glDrawArrays(gl.GL_LINES, first, count)
    else:
        gl.glDrawArrays(gl.GL_LINES, 0, len(points) // (3 * _FLOAT_BYTES))
    gl.glPopClientAttrib()


def draw_dwells(geometry, dwells, alpha, for_selection, is_lathe):
    """draw_dwells(GEOMETRY, DWELLS, ALPHA, FOR_SELECTION, IS_LATHE): draws marks (number, color, x, y, z, plane)."""
    gl = _gl()
    size = DWELL_SIZE
    if not for_selection:
        gl.glBegin(gl.GL_LINES)
    for number, color, x, y, z, plane in dwells:
        across = 1 if is_lathe else {0: 2, 1: 1, 2: 0}.get(plane, 2)
        in_plane = [n for n in range(3) if n != across]
        if for_selection:
            gl.glLoadName(number)
            gl.glBegin(gl.GL_LINES)
        else:
            gl.glColor4d(*color, alpha)
        for sign in (1, -1):
            for end in (1, -1):
                point = [x, y, z]
                point[in_plane[0]] += end * size
                point[in_plane[1]] += end * sign * size
                gl.glVertex3d(*point)
        if for_selection:
            gl.glEnd()
    if not for_selection:
        gl.glEnd()
