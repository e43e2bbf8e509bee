"""The path that a machine has gone, as a drawing."""

import threading
from array import array

from . import _drawing
from ._constants import *

#: Largest number of points; the oldest ones give way.
MAX_POINTS = 10000
MM_PER_INCH = 25.4
#: Points closer together than this, in inches, are one.
_NEAR = 1e-4
#: Largest distance of a point from the line between its neighbours for it to be left out, in inches.
_STRAIGHT = 1e-6


def _is_between(a, b, c):
    """Tells whether a point lies on the line from `a` to `c`."""
    ab = [q - p for p, q in zip(a, b)]
    ac = [q - p for p, q in zip(a, c)]
    cross = (ab[1] * ac[2] - ab[2] * ac[1], ab[2] * ac[0] - ab[0] * ac[2], ab[0] * ac[1] - ab[1] * ac[0])
    along = sum(p * q for p, q in zip(ab, ac))
    length = sum(p * p for p in ac)
    return 0.0 <= along <= length and sum(v * v for v in cross) <= _STRAIGHT**2 * length


class positionlogger:
    """positionlogger(STAT, JOG, TRAVERSE, FEED, ARC, TOOLCHANGE, PROBE, GEOMETRY[, IS_XYUV])."""

    def __init__(self, stat, jog, traverse, feed, arc, toolchange, probe, geometry, is_xyuv=0):
        self._stat = stat
        self._colors = [tuple(c) for c in (jog, traverse, feed, arc, toolchange, probe)]
        self._geometry = geometry
        self._is_foam = bool(is_xyuv)
        self._depth = (0.0, 0.0)
        self._stopped = threading.Event()
        self._lock = threading.Lock()
        self._points = []
        #: Place of the newest point.
        self._place = None

    @property
    def npts(self):
        """Number of points."""
        return len(self._points)

    def start(self, interval):
        """start(SECONDS): adds a point at each interval, until `stop`."""
        self._stopped.clear()
        while not self._stopped.wait(interval):
            try:
                self._stat.poll()
            except RuntimeError:
                return
            self._add()

    def stop(self):
        """Ends `start`."""
        self._stopped.set()

    def clear(self):
        """Removes all points."""
        with self._lock:
            self._points.clear()

    def set_depth(self, z, w):
        """set_depth(Z, W): sets the heights of the two planes of a foam cutter."""
        self._depth = (z, w)

    def set_colors(self, jog, traverse, feed, arc, toolchange, probe):
        """Sets the colors of the points to come."""
        self._colors = [tuple(c) for c in (jog, traverse, feed, arc, toolchange, probe)]

    def get_colors(self):
        """Returns the colors."""
        return tuple(self._colors)

    def last(self, flag=1):
        """last([FLAG]): returns the newest place that `start` has read, in machine units; the present one for 0."""
        if flag and self._place is not None:
            return self._place
        try:
            self._stat.poll()
        except RuntimeError:
            return None
        return self._stat.actual_position

    def _add(self):
        stat = self._stat
        scale = 1 / (stat.linear_units * MM_PER_INCH)
        place = tuple(v if 3 <= n < 6 else v * scale for n, v in enumerate(stat.actual_position))
        if self._is_foam:
            z, w = self._depth
            point = (place[0], place[1], z)
            other = (place[6], place[7], w)
        else:
            point = other = _drawing.vertex9(self._geometry, place)
        kind = stat.motion_type if 0 <= stat.motion_type < len(self._colors) else 0
        self._place = stat.actual_position
        with self._lock:
            points = self._points
            if points and all(abs(p - q) < _NEAR for p, q in zip(points[-1][0] + points[-1][1], point + other)):
                return
            entry = (point, other, self._colors[kind])
            # A point on the way from the one before to the new one says nothing.
            if (len(points) > 1 and points[-1][2] == points[-2][2] == entry[2]
                    and _is_between(points[-2][0], points[-1][0], point)
                    and (not self._is_foam or _is_between(points[-2][1], points[-1][1], other))):
                points[-1] = entry
            else:
                points.append(entry)
                del points[:-MAX_POINTS]

    def call(self):
        """Draws the path."""
        with self._lock:
            points = list(self._points)
        if not points:
            return
        gl = _drawing._gl()
        colors = array("B", (v for p in points for v in p[2])).tobytes()
        gl.glPushClientAttrib(gl.GL_CLIENT_VERTEX_ARRAY_BIT)
        gl.glEnableClientState(gl.GL_VERTEX_ARRAY)
        gl.glEnableClientState(gl.GL_COLOR_ARRAY)
        gl.glColorPointer(4, gl.GL_UNSIGNED_BYTE, 0, colors)
        for which in (0, 1) if self._is_foam else (0,):
            vertices = array("f", (v for p in points for v in p[which])).tobytes()
            gl.glVertexPointer(3, gl.GL_FLOAT, 0, vertices)
            gl.glDrawArrays(gl.GL_LINE_STRIP, 0, len(points))
        gl.glPopClientAttrib()
