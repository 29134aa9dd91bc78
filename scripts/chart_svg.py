"""One chart of lines as an SVG image, for documents."""
import html
import math

WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 720, 440, 70, 20, 20, 56
COLOURS = ["#b5432e", "#1f6f80", "#7a7f88", "#8a6d1f", "#4b3f72", "#2f7d4f"]


def ticks(low, high, count=6):
    """Round numbers from low to high."""
    raw = (high - low) / count
    unit = 10 ** math.floor(math.log10(raw))
    step = next(unit * m for m in (1, 2, 5, 10) if unit * m >= raw * 0.999)
    first = math.ceil(low / step - 1e-9)
    return [round(i * step, 10) for i in range(first, int(high / step + 1e-9) + 1)]


def chart(path, x_title, y_title, series, log_y=False, x_range=None, y_range=None, legend_top=TOP + 24):
    """series: (title, points) each; a title that begins with "-" is drawn dashed, without it."""
    points = [p for _, line in series for p in line]
    x0, x1 = x_range or (min(p[0] for p in points), max(p[0] for p in points))
    y0, y1 = y_range or (min(p[1] for p in points), max(p[1] for p in points))
    scale = math.log10 if log_y else float
    y0, y1 = scale(y0), scale(y1)

    def x(value):
        return LEFT + (value - x0) / (x1 - x0) * (WIDTH - LEFT - RIGHT)

    def y(value):
        return HEIGHT - BOTTOM - (scale(value) - y0) / (y1 - y0) * (HEIGHT - TOP - BOTTOM)

    parts = ['<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 %d %d" font-family="sans-serif" font-size="14">' % (WIDTH, HEIGHT),
             '<rect width="100%" height="100%" fill="#fff"/>']
    y_ticks = [10.0 ** e for e in range(math.ceil(y0), math.floor(y1) + 1)] if log_y else ticks(y0, y1)
    for t in ticks(x0, x1):
        parts.append('<path d="M%.1f %dV%d" stroke="#e3e3e0"/><text x="%.1f" y="%d" text-anchor="middle">%g</text>'
                     % (x(t), TOP, HEIGHT - BOTTOM, x(t), HEIGHT - BOTTOM + 20, t))
    for t in y_ticks:
        parts.append('<path d="M%d %.1fH%d" stroke="#e3e3e0"/><text x="%d" y="%.1f" text-anchor="end">%g</text>'
                     % (LEFT, y(t), WIDTH - RIGHT, LEFT - 8, y(t) + 5, t))
    for i, (title, line) in enumerate(series):
        colour, dashed = COLOURS[i % len(COLOURS)], title.startswith("-")
        shown = [p for p in line if y0 <= scale(p[1]) <= y1] if log_y else line
        parts.append('<polyline fill="none" stroke="%s" stroke-width="2"%s points="%s"/>' % (
            colour, ' stroke-dasharray="6 4"' if dashed else "", " ".join("%.1f,%.1f" % (x(p[0]), y(p[1])) for p in shown)))
        parts.append('<text x="%d" y="%d" text-anchor="end" fill="%s">%s%s</text>' % (
            WIDTH - RIGHT - 12, legend_top + 20 * i, colour, "- - " if dashed else "— ", html.escape(title.lstrip("-"))))
    parts.append('<text x="%d" y="%d" text-anchor="middle">%s</text>' % ((LEFT + WIDTH - RIGHT) // 2, HEIGHT - 10, html.escape(x_title)))
    parts.append('<text transform="translate(16 %d) rotate(-90)" text-anchor="middle">%s</text></svg>'
                 % ((TOP + HEIGHT - BOTTOM) // 2, html.escape(y_title)))
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(parts) + "\n")
