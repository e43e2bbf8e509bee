"""Waveforms as pictures in SVG."""

import math
from xml.sax.saxutils import escape

_WIDTH, _ROW, _GAP, _LEFT, _RIGHT, _FOOT = 900, 56, 14, 190, 70, 34
_LINE, _GRID, _TEXT = "#1f5fa8", "#d8dde3", "#26323e"


def _step(span, most):
    """Returns a round distance that divides the span into at most this many parts."""
    if span <= 0:
        return 1.0
    power = 10.0 ** math.floor(math.log10(span / most))
    return next(power * n for n in (1, 2, 5, 10) if span / (power * n) <= most)


def _time(seconds, step):
    for unit, scale in (("s", 1.0), ("ms", 1e3), ("us", 1e6)):
        if step * scale >= 0.1:
            return "%.10g %s" % (round(seconds * scale, 6), unit)
    return "%.10g ns" % round(seconds * 1e9, 3)


def _number(value):
    return "%d" % value if isinstance(value, bool) else "%.4g" % value


def svg(capture):
    """Returns a picture of a capture: bits as levels, other values as steps between their extremes."""
    waves = list(capture)
    height = len(waves) * (_ROW + _GAP) + _GAP + _FOOT
    span = max(capture.end - capture.begin, 1e-9)
    across = (_WIDTH - _LEFT - _RIGHT) / span
    bottom = height - _FOOT
    out = ['<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 %d %d" width="%d" height="%d" '
           'font-family="sans-serif" font-size="12">' % (_WIDTH, height, _WIDTH, height),
           '<rect width="100%" height="100%" fill="white"/>']
    step = _step(span, 8)
    for n in range(int(span / step + 1e-9) + 1):
        x = _LEFT + n * step * across
        out.append('<path d="M%.1f %d V%d" stroke="%s"/>' % (x, _GAP, bottom, _GRID))
        out.append('<text x="%.1f" y="%d" fill="%s" text-anchor="middle">%s</text>'
                   % (x, bottom + 18, _TEXT, _time(n * step, step)))
    for row, wave in enumerate(waves):
        out += _row(wave, _GAP + row * (_ROW + _GAP), across, capture)
    out.append("</svg>")
    return "\n".join(out)


def _row(wave, top, across, capture):
    numbers = [float(v) for v in wave.values if math.isfinite(v)] or [0.0]
    low, high = (0.0, 1.0) if wave.is_bit else (min(numbers), max(numbers))
    height = (high - low) or 1.0

    def y(value):
        value = float(value) if math.isfinite(value) else low
        return top + _ROW - (value - low) / height * _ROW

    path = []
    for time, value in zip(wave.times, wave.values):
        x = _LEFT + (time - capture.begin) * across
        path.append(("H%.2f V%.2f" if path else "M%.2f %.2f") % (x, y(value)))
    if path:
        path.append("H%.2f" % (_LEFT + (capture.end - capture.begin) * across))
    right = _WIDTH - _RIGHT + 8
    out = ['<text x="%d" y="%d" fill="%s" text-anchor="end">%s</text>'
           % (_LEFT - 12, top + _ROW // 2 + 4, _TEXT, escape(wave.name)),
           '<path d="%s" fill="none" stroke="%s" stroke-width="1.5"/>' % (" ".join(path), _LINE)]
    if not wave.is_bit:
        out += ['<text x="%d" y="%d" fill="%s">%s</text>' % (right, top + 10, _TEXT, _number(high)),
                '<text x="%d" y="%d" fill="%s">%s</text>' % (right, top + _ROW, _TEXT, _number(low))]
    return out
