"""Charts as SVG images, for documents: lines over axes, lines about a pole, and several of them on one sheet."""
import html
import math

WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 720, 440, 70, 20, 20, 56
COLOURS = ["#b5432e", "#1f6f80", "#7a7f88", "#8a6d1f", "#4b3f72", "#2f7d4f"]
GRID = "#e3e3e0"


def ticks(low, high, count=6):
    """Round numbers from low to high."""
    raw = (high - low) / count
    unit = 10 ** math.floor(math.log10(raw))
    step = next(unit * m for m in (1, 2, 5, 10) if unit * m >= raw * 0.999)
    first = math.ceil(low / step - 1e-9)
    return [round(i * step, 10) for i in range(first, int(high / step + 1e-9) + 1)]


def log_ticks(low, high, mantissas):
    """Those numbers times powers of ten from low to high."""
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    return [m * 10.0 ** e for e in decades for m in mantissas if low * 0.999 <= m * 10.0 ** e <= high * 1.001]


def polyline(points, colour, dashed):
    """Without points that are closer than a pixel and a half to the one before, but for the last."""
    kept = []
    for i, point in enumerate(points):
        if not kept or i == len(points) - 1 or math.dist(point, kept[-1]) > 1.5:
            kept.append(point)
    return '<polyline fill="none" stroke="%s" stroke-width="2"%s points="%s"/>' % (
        colour, ' stroke-dasharray="6 4"' if dashed else "", " ".join("%.1f,%.1f" % p for p in kept))


def legend(series, top):
    parts = []
    for i, (title, _, colour, dashed) in enumerate(styled(series)):
        parts.append('<text x="%d" y="%d" text-anchor="end" fill="%s">%s%s</text>' % (
            WIDTH - RIGHT - 12, top + 20 * i, colour, "- - " if dashed else "— ", html.escape(title)))
    return parts


def styled(series):
    """(title, points, colour, dashed) of (title, points) or (title, points, number of a colour)."""
    for i, (title, points, *number) in enumerate(series):
        yield title.lstrip("-"), points, COLOURS[(number[0] if number else i) % len(COLOURS)], title.startswith("-")


def lines(x_title, y_title, series, log_x=False, log_y=False, x_range=None, y_range=None, legend_top=TOP + 24, title=""):
    """What a chart consists of. series: (title, points) each, and the number of a colour unless each has its own; a title that begins
    with "-" is drawn dashed, without it."""
    points = [p for _, line, *_ in series for p in line]
    x0, x1 = x_range or (min(p[0] for p in points), max(p[0] for p in points))
    y0, y1 = y_range or (min(p[1] for p in points), max(p[1] for p in points))
    scale_x, scale_y = (math.log10 if log else float for log in (log_x, log_y))

    def x(value):
        return LEFT + (scale_x(value) - scale_x(x0)) / (scale_x(x1) - scale_x(x0)) * (WIDTH - LEFT - RIGHT)

    def y(value):
        return HEIGHT - BOTTOM - (scale_y(value) - scale_y(y0)) / (scale_y(y1) - scale_y(y0)) * (HEIGHT - TOP - BOTTOM)

    parts = []
    for t in log_ticks(x0, x1, (1, 2, 5)) if log_x else ticks(x0, x1):
        parts.append('<path d="M%.1f %dV%d" stroke="%s"/><text x="%.1f" y="%d" text-anchor="middle">%g</text>'
                     % (x(t), TOP, HEIGHT - BOTTOM, GRID, x(t), HEIGHT - BOTTOM + 20, t))
    for t in log_ticks(y0, y1, (1,)) if log_y else ticks(y0, y1):
        parts.append('<path d="M%d %.1fH%d" stroke="%s"/><text x="%d" y="%.1f" text-anchor="end">%g</text>'
                     % (LEFT, y(t), WIDTH - RIGHT, GRID, LEFT - 8, y(t) + 5, t))
    for _, line, colour, dashed in styled(series):
        shown = [p for p in line if x0 <= p[0] <= x1 and (y0 <= p[1] <= y1 or not log_y)]
        parts.append(polyline([(x(a), y(b)) for a, b in shown], colour, dashed))
    parts += legend(series, legend_top)
    parts.append('<text x="%d" y="%d" text-anchor="middle">%s</text>' % ((LEFT + WIDTH - RIGHT) // 2, HEIGHT - 10, html.escape(x_title)))
    parts.append('<text transform="translate(16 %d) rotate(-90)" text-anchor="middle">%s</text>'
                 % ((TOP + HEIGHT - BOTTOM) // 2, html.escape(y_title)))
    parts.append('<text x="%d" y="%d" font-weight="bold">%s</text>' % (LEFT + 10, TOP + 20, html.escape(title)))
    return "\n".join(parts)


def polar(series, low, high, incidence, legend_top=TOP + 24, title=""):
    """Curves about a pole, the logarithm of the value as radius.
    @param series     as for lines(); points are (angle from the axis [degrees], 0 up and 90 to the right; value)
    @param low, high  values at the middle and at the rim
    @param incidence  where the light flies to [degrees]: an arrow"""
    cx, cy, size = WIDTH // 2 - 60, HEIGHT // 2, HEIGHT // 2 - 26

    def at(degrees, radius):
        return cx + size * radius * math.sin(math.radians(degrees)), cy - size * radius * math.cos(math.radians(degrees))

    def radius(value):
        return max(0.0, math.log10(max(value, low) / low) / math.log10(high / low))

    parts = []
    for t in log_ticks(low, high, (1,)):
        r = size * radius(t)
        parts.append('<circle cx="%d" cy="%d" r="%.1f" fill="none" stroke="%s"/><text x="%d" y="%.1f" fill="#888" font-size="12">%g</text>'
                     % (cx, cy, r, GRID, cx + 3, cy + r - 3, t))
    for degrees in range(0, 360, 30):
        parts.append('<path d="M%d %dL%.1f %.1f" stroke="%s"/>' % (cx, cy, *at(degrees, 1), GRID))
    for title_of, line, colour, dashed in styled(series):
        parts.append(polyline([at(a, radius(b)) for a, b in line], colour, dashed))
    (x0, y0), (x1, y1) = at(incidence + 180, 1.1), at(incidence + 180, 0.8)
    parts.append('<path d="M%.1f %.1fL%.1f %.1f" stroke="#222" stroke-width="3"/>' % (x0, y0, x1, y1))
    parts.append('<path d="M-9 -12L0 0L9 -12" transform="translate(%.1f %.1f) rotate(%g)" fill="none" stroke="#222" stroke-width="3"/>'
                 % (x1, y1, 180 + incidence))
    parts += legend(series, legend_top)
    parts.append('<text x="12" y="%d" font-weight="bold">%s</text>' % (TOP + 20, html.escape(title)))
    return "\n".join(parts)


def sheet(path, drawings, columns=1):
    """Charts of lines() and polar(), row by row."""
    rows = -(-len(drawings) // columns)
    parts = ['<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 %d %d" font-family="sans-serif" font-size="14">'
             % (WIDTH * columns, HEIGHT * rows), '<rect width="100%" height="100%" fill="#fff"/>']
    for i, drawing in enumerate(drawings):
        parts.append('<g transform="translate(%d %d)">\n%s</g>' % (i % columns * WIDTH, i // columns * HEIGHT, drawing))
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(parts) + "</svg>\n")


def chart(path, *arguments, **options):
    """One chart of lines()."""
    sheet(path, [lines(*arguments, **options)])
