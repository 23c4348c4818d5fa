"""Drawings: the task, its scores, and the parts of the project. Each is an SVG that follows light and dark."""

import math
from collections.abc import Mapping, Sequence
from xml.sax.saxutils import escape

from arramon_server.scoring.metrics import ndtw, rpod
from website.figures.style import COLOURS

Point = tuple[float, float]

FONT = 'font-family="system-ui, Segoe UI, Roboto, sans-serif"'


def all_drawings() -> Mapping[str, str]:
    """Return the drawings, as SVG, by name."""
    return {"task": task(), "ndtw": ndtw_drawing(), "ctc": ctc(), "rpod": rpod_drawing(), "cascade": cascade(),
            "architecture": architecture()}  # fmt: skip


def _svg(width: int, height: int, title: str, *parts: str) -> str:
    body = "\n".join(parts)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" role="img" '
        f'{FONT} font-size="14">\n<title>{escape(title)}</title>\n{COLOURS}'
        '<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" orient="auto-start-reverse">'
        '<path d="M0 0 8 4 0 8z" fill="context-stroke"/></marker></defs>\n'
        f"{body}\n</svg>\n"
    )


def _text(
    x: float, y: float, text: str, *, anchor: str = "start", colour: str = "ink", size: int = 14, bold: bool = False
) -> str:
    weight = ' font-weight="600"' if bold else ""
    return f'<text x="{x:g}" y="{y:g}" text-anchor="{anchor}" fill="var(--{colour})" font-size="{size}"{weight}>{escape(text)}</text>'


def _box(
    x: float, y: float, width: float, height: float, *, colour: str = "line", fill: str = "var(--fill)", radius: int = 8
) -> str:
    return (
        f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="{radius}" fill="{fill}" stroke="var(--{colour})" '
        'stroke-width="1.5"/>'
    )


def _line(points: Sequence[Point], colour: str, *, tip: bool = True, dash: str = "", width: float = 2.5) -> str:
    path = " ".join(f"{x:g},{y:g}" for x, y in points)
    more = (' marker-end="url(#tip)"' if tip else "") + (f' stroke-dasharray="{dash}"' if dash else "")
    return f'<polyline points="{path}" fill="none" stroke="var(--{colour})" stroke-width="{width:g}" stroke-linejoin="round"{more}/>'


def _dot(x: float, y: float, colour: str, radius: float = 6, *, hollow: bool = False) -> str:
    fill = "none" if hollow else f"var(--{colour})"
    return f'<circle cx="{x:g}" cy="{y:g}" r="{radius:g}" fill="{fill}" stroke="var(--{colour})" stroke-width="2"/>'


def task() -> str:
    """Return the task in one drawing: two turns, each a walk in the city and a placement in the room."""
    parts = []
    for turn, x in ((1, 10), (2, 420)):
        parts += [
            _text(x, 24, f"Turn {turn}", bold=True, size=16),
            _box(x, 36, 190, 190),
            *(_box(x + dx, 36 + dy, 62, 62, fill="var(--line)", radius=2) for dx in (14, 114) for dy in (14, 114)),
            _line(
                [(x + 95, 214), (x + 95, 131), (x + 155, 131)]
                if turn == 1
                else [(x + 20, 131), (x + 95, 131), (x + 95, 62)],
                "first",
            ),
            _dot(*((x + 95, 216) if turn == 1 else (x + 16, 131)), "ink", 4),
            _dot(*((x + 170, 131) if turn == 1 else (x + 95, 48)), "second"),
            _text(x + 95, 246, "Navigation, in the city", anchor="middle", colour="soft"),
            _line([(x + 192, 131), (x + 212, 131)], "ink"),
            _box(x + 216, 36, 150, 190),
            *(
                _line([(x + 216 + 30 * i, 36), (x + 216 + 30 * i, 226)], "line", tip=False, width=1)
                for i in range(1, 5)
            ),
            *(_line([(x + 216, 36 + 38 * i), (x + 366, 36 + 38 * i)], "line", tip=False, width=1) for i in range(1, 5)),
            f'<rect x="{x + 222}" y="80" width="18" height="26" fill="var(--soft)"/>',
            f'<rect x="{x + 312}" y="156" width="18" height="26" fill="var(--soft)"/>',
            _dot(x + 291, 93, "second", hollow=True),
            _text(x + 291, 246, "Assembly, in the room", anchor="middle", colour="soft"),
        ]
    parts += [
        _line([(378, 131), (416, 131)], "ink"),
        _text(10, 276, "“Go straight to the crossing, turn right, and pick up the", colour="first", size=13),
        _text(10, 293, "striped red mug by the traffic light.”", colour="first", size=13),
        _text(10, 316, "“Place the mug to the right of the blue bowl.”", colour="first", size=13),
        _text(420, 276, "Turn 2 begins where turn 1 ended, with new instructions:", size=13),
        _text(420, 293, "an error in one phase carries over into the next.", size=13),
        _text(420, 316, "Four actions: forward, left, right, pick up or place.", size=13),
    ]
    return _svg(800, 330, "An episode: two turns, each a navigation and an assembly", *parts)


def _units(points: Sequence[Point], x: float, y: float, scale: float) -> list[Point]:
    return [(x + scale * px, y - scale * py) for px, py in points]


def _nearest(at: Point, points: Sequence[Point]) -> Point:
    return min(points, key=lambda point: math.dist(point, at))


def ndtw_drawing() -> str:
    """Return a drawing of nDTW: three paths beside one reference, with their scores."""
    reference = [(0.0, float(i)) for i in range(8)] + [(float(i), 7.0) for i in range(1, 8)]
    paths = {
        "beside it": [(0.8 + 0.0 * i, float(i)) for i in range(8)] + [(float(i), 6.4) for i in range(2, 8)],
        "a turn too late": [(0.0, float(i)) for i in range(11)] + [(float(i), 10.0) for i in range(1, 8)],
        "stops half-way": [(0.0, float(i)) for i in range(7)],
    }
    parts = [_text(10, 22, "nDTW: how close is the whole path to the reference, in order?", bold=True)]
    for index, (name, path) in enumerate(paths.items()):
        x = 50 + 250 * index
        drawn, true = _units(path, x, 250, 18), _units(reference, x, 250, 18)
        ties = [_line([at, _nearest(at, true)], "soft", tip=False, width=0.8) for at in drawn[::2]]
        parts += [
            *ties, _line(true, "third", dash="6 4"), _line(drawn, "first"), _dot(*true[0], "ink", 4),
            _text(x - 10, 280, f"{name}: {ndtw(path, reference):.2f}"),
        ]  # fmt: skip
    parts += [
        _line([(10, 306), (40, 306)], "third", tip=False, dash="6 4"), _text(46, 311, "reference", colour="soft"),
        _line([(130, 306), (160, 306)], "first", tip=False), _text(166, 311, "the agent’s path", colour="soft"),
        _text(300, 311, "exp(−cost of the best alignment / (3 units × points of the reference))", colour="soft", size=13),
    ]  # fmt: skip
    return _svg(800, 324, "nDTW of three paths", *parts)


def ctc() -> str:
    """Return a drawing of CTC-k: where a walk may end for the pick-up to count."""
    x, y, scale = 200, 170, 20
    rings = [
        f'<circle cx="{x}" cy="{y}" r="{k * scale}" fill="none" stroke="var(--soft)" stroke-dasharray="4 4"/>'
        for k in (7, 5, 3)
    ]
    parts = [
        _text(10, 22, "CTC-k: did the walk end within k units of the target?", bold=True),
        *rings,
        *(_text(x + 4, y - k * scale + 14, f"k = {k}", colour="soft", size=12) for k in (3, 5, 7)),
        _dot(x, y, "second"),
        _text(x + 12, y + 5, "target", size=13),
        _dot(x + 70, y + 45, "first", 5),
        _text(x + 80, y + 50, "ends here: CTC-5, CTC-7", size=13, colour="first"),
        _text(460, 110, "CTC-0: the target itself was picked up"),
        _text(460, 140, "CTC-3, CTC-5, CTC-7: the agent stopped"),
        _text(460, 160, "nearer to it than 3, 5 or 7 units"),
    ]
    return _svg(800, 324, "CTC-k: circles around the target", *parts)


def rpod_drawing() -> str:
    """Return a drawing of rPOD and PTC: the value of each cell of the room around the target cell."""
    size, x, y = 58, 30, 44
    parts = [_text(10, 22, "rPOD and PTC: how near to its goal was the object placed?", bold=True)]
    for row in range(4):
        for column in range(5):
            distance = abs(column - 2) + abs(row - 1)
            value = rpod(distance)
            left, top = x + size * column, y + size * row
            parts += [
                f'<rect x="{left}" y="{top}" width="{size}" height="{size}" fill="var(--first)" fill-opacity="{0.05 + 0.55 * value:.2f}" '
                'stroke="var(--line)"/>',
                _text(left + size / 2, top + 34, f"{value:.2f}", anchor="middle", bold=distance == 0),
            ]  # fmt: skip
    parts += [
        f'<rect x="{x + 2 * size}" y="{y + size}" width="{size}" height="{size}" fill="none" stroke="var(--second)" stroke-width="3"/>',
        _text(380, 110, "rPOD = 1 / (1 + D²), D: columns and rows"),
        _text(380, 130, "between the object and its goal"),
        _text(380, 170, "PTC = 1 in the goal’s cell, else 0"),
        _text(380, 210, "Both are 0 where CTC-3 is 0: who has not", colour="soft"),
        _text(380, 230, "found the object has nothing to place.", colour="soft"),
    ]
    return _svg(800, 300, "rPOD of each cell around the goal", *parts)


def cascade() -> str:
    """Return a drawing of how the phases of an episode depend on each other."""
    names = (
        ("Navigation 1", "nDTW, CTC-k"),
        ("Assembly 1", "rPOD, PTC"),
        ("Navigation 2", "nDTW, CTC-k"),
        ("Assembly 2", "rPOD, PTC"),
    )
    parts = []
    for index, (name, scores) in enumerate(names):
        x = 10 + 200 * index
        parts += [
            _box(x, 40, 160, 70, colour="first" if index % 2 == 0 else "second"),
            _text(x + 80, 70, name, anchor="middle", bold=True),
            _text(x + 80, 94, scores, anchor="middle", colour="soft"),
        ]
        if index < 3:
            parts.append(_line([(x + 162, 75), (x + 196, 75)], "ink"))
    parts += [
        _text(90, 140, "gate: CTC-3", anchor="start", colour="second"), _line([(170, 132), (182, 112)], "second", width=1.5),
        _text(10, 164, "Assembly scores only if the walk ended near the target.", size=13, colour="soft"),
        _text(420, 140, "starts where turn 1 ended", colour="first"), _line([(490, 128), (490, 112)], "first", width=1.5),
        _text(420, 164, "A wrong first turn makes the second one harder.", size=13, colour="soft"),
    ]  # fmt: skip
    return _svg(800, 176, "Four phases, and the gates between them", *parts)


def architecture() -> str:
    """Return the parts of the project and what passes between them."""
    boxes: list[tuple[float, float, float, str, str, Sequence[str]]] = [
        (10, 40, 220, "Agent", "first", ("begin(episode)", "act(observations) → actions")),
        (10, 180, 220, "Client", "first", ("arramon-client", "batches, retries, recordings")),
        (
            300,
            110,
            220,
            "Server",
            "second",
            ("engine: episodes, clocks", "simulator, rules, scores", "journal: every step"),
        ),
        (580, 20, 210, "Pages", "third", ("leaderboard, play, watch", "collections of texts")),
        (580, 120, 210, "Data", "third", ("splits, sections, texts", "hidden ones stay here")),
        (580, 220, 210, "Journal", "third", ("SQLite or PostgreSQL", "receipts, exports")),
    ]
    parts = []
    for x, y, width, name, colour, lines in boxes:
        parts += [_box(x, y, width, 40 + 20 * len(lines), colour=colour), _text(x + 14, y + 24, name, bold=True)]
        parts += [_text(x + 14, y + 46 + 19 * index, line, size=13, colour="soft") for index, line in enumerate(lines)]
    parts += [
        _line([(110, 176), (110, 124)], "ink"), _text(120, 155, "observations", size=12, colour="soft"),
        _line([(60, 124), (60, 176)], "ink"), _text(14, 155, "actions", size=12, colour="soft"),
        _line([(234, 205), (296, 175)], "ink"), _line([(296, 190), (234, 222)], "ink"), _text(240, 246, "gRPC", size=13, colour="soft"),
        _line([(524, 130), (576, 75)], "ink"), _line([(576, 160), (524, 160)], "ink"), _line([(524, 190), (576, 245)], "ink"),
        _text(10, 22, "On the participant’s machine", colour="soft", size=13), _text(300, 22, "On the host", colour="soft", size=13),
    ]  # fmt: skip
    return _svg(800, 320, "The parts of the project", *parts)
