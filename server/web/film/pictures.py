"""The pictures of a film: frame and map side by side, below them instruction, action, answer and note."""

from collections.abc import Iterator, Sequence
from typing import Any

from PIL import Image, ImageDraw

from arramon_server.playback.pictures import draw as draw_frame
from arramon_server.web.film.film_map import EDGE, GOAL, TEXT, WHITE, FilmMap
from arramon_server.web.film.lettering import fitting, wrapped, write
from arramon_server.web.page_texts import PageTexts
from arramon_server.web.watch.moment_views import MomentViews
from arramon_server.web.watch.playbacks import OpenPlayback

MARGIN, GAP = 10, 8
"""Margin of a picture and gap between its parts, in pixels."""

LETTERS, LINE = 14, 19
"""Size of letters and height of a line, in pixels."""

INSTRUCTION_LINES = 4


def pictures(
    t: PageTexts,
    context: dict[str, Any],
    views: MomentViews,
    opened: OpenPlayback,
    steps: Sequence[int],
    size: int,
) -> Iterator[Image.Image]:
    """Yield the picture of each of some steps.

    Args:
        t: texts in the film's language.
        context: variables of `WatchPart.context`.
        views: the moments.
        opened: the playback.
        steps: the steps to show.
        size: side of frame and map, in pixels.
    """
    maps: dict[int, FilmMap] = {}
    for step in steps:
        moment = views.view(step)
        turn = moment["turn"]
        if turn not in maps:
            maps[turn] = FilmMap(t, context["ground"], context["stages"][turn - 1], size)
        note = views.note(moment["note"]) if moment["note"] >= 0 else None
        reading = views.note(moment["reading"])["reading"] if moment["reading"] >= 0 else ()
        above = maps[turn].picture(
            in_room=moment["phase"] == "assembly",
            trail=views.trail(step),
            heading=moment["heading"],
            goal=note["goal"] if note else None,
        )
        frame = Image.fromarray(draw_frame(opened.world, opened.playback.moment(step).state, size))
        yield _composed(frame, above, _lines(t, context, moment, note, reading))


def _lines(
    t: PageTexts, context: dict[str, Any], moment: dict[str, Any], note: dict[str, Any] | None, reading: Sequence[str]
) -> tuple[str, str, str, str]:
    """Return the phase, the instruction, what happens, and the note, one text each."""
    key = f"{moment['turn']}-{moment['phase']}"
    texts = context["texts"]
    happens = [f"{t('watch.step')} {moment['step']}/{context['last']}", moment["action"], moment["answer"]]
    if moment["ndtw"]:
        happens += [f"nDTW {moment['ndtw']}", moment["distance"]]
    said = ""
    if note is not None:
        step = note["step"]
        facts = [f"{name}: {text}" for name, text in note["facts"]]
        current = f"{step}. {reading[step - 1]}" if 0 < step <= len(reading) else ""
        said = (
            f"{t('watch.note')}: {current or '; '.join(facts) or '; '.join(reading) or ' '.join(note['text'].split())}"
        )
    return texts["phases"][key], texts["instructions"][key], "  ·  ".join(filter(None, happens)), said


def _composed(frame: Image.Image, above: Image.Image, lines: tuple[str, str, str, str]) -> Image.Image:
    phase, instruction, happens, said = lines
    side = frame.width
    width = 2 * side + 2 * MARGIN + GAP
    inner = width - 2 * MARGIN
    top = MARGIN + side + GAP
    height = top + (INSTRUCTION_LINES + 3) * LINE + MARGIN
    image = Image.new("RGB", (width + width % 2, height + height % 2), WHITE)  # even sides, as videos need
    image.paste(frame, (MARGIN, MARGIN))
    image.paste(above, (MARGIN + side + GAP, MARGIN))
    draw = ImageDraw.Draw(image)
    write(draw, (MARGIN, top + LETTERS), fitting(phase, LETTERS, inner), LETTERS, EDGE)
    for number, line in enumerate(wrapped(instruction, LETTERS, inner, INSTRUCTION_LINES), start=1):
        write(draw, (MARGIN, top + LETTERS + number * LINE), line, LETTERS, TEXT)
    below = top + LETTERS + (INSTRUCTION_LINES + 1) * LINE
    write(draw, (MARGIN, below), fitting(happens, LETTERS, inner), LETTERS, TEXT)
    if said:
        write(draw, (MARGIN, below + LINE), fitting(said, LETTERS, inner), LETTERS, GOAL)
    return image
