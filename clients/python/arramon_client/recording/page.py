"""Web pages of a recorded run: a self-contained page for each episode, and an index; they need no network."""

import base64
import html
import json
import tomllib
from collections.abc import Iterator, Mapping
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from arramon_client.files import write_whole
from arramon_client.printable import many_lines
from arramon_client.recording.files import ABOUT, PAGE, STEPS

INDEX = "index.html"

_FALLBACK = "en"


def write_page(folder: Path, facts: Mapping[str, str]) -> None:
    """Write an episode's page from its files, atomically.

    Args:
        folder: the episode's folder.
        facts: facts about the run: `run`, `agent`, `split` and `language`.

    Raises:
        OSError, OutputError: if something cannot be read or written.
    """
    about = json.loads((folder / ABOUT).read_bytes())
    language, texts = _texts(facts["language"])
    left_out = about["pictures_left_out"]
    cause = texts["cause"].format(cause=_cause(texts, about), steps=about["steps"])
    values = {
        **{name: text for name, text in texts.items() if isinstance(text, str)},
        **facts,
        "language": language,
        "spoken": about["language"],
        "title": texts["title"].format(id=about["episode_id"]),
        "cause": cause,
        "left_out": texts["left_out"].format(number=left_out),
    }
    whole = {
        "style": _part("style.css"),
        "script": _part("episode.js"),
        "left_out_hidden": "" if left_out else "hidden",
    }
    before, _, after = _filled("episode.html", values, whole).rpartition("{{data}}")
    write_whole(folder / PAGE, before, *_data(folder, about, texts), after)


def write_index(folder: Path, facts: Mapping[str, str]) -> None:
    """Write the page that lists the recorded episodes.

    Args:
        folder: the run's folder.
        facts: as for `write_page`.

    Raises:
        OSError, OutputError: if something cannot be read or written.
    """
    language, texts = _texts(facts["language"])
    found = [(path.parent.name, json.loads(path.read_bytes())) for path in sorted(folder.glob(f"*/{ABOUT}"))]
    rows = "".join(
        f'<tr><td><a href="{html.escape(name)}/{PAGE}">{html.escape(about["episode_id"])}</a></td>'
        f"<td>{about['steps']}</td><td>{html.escape(_cause(texts, about))}</td></tr>\n"
        for name, about in found
    )
    headings = "".join(f'<th scope="col">{texts[name]}</th>' for name in ("episode", "steps_heading", "cause_heading"))
    table = f"<table>\n<thead><tr>{headings}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table>"
    values = {
        **facts,
        "language": language,
        "spoken": facts["language"],
        "title": texts["index_title"].format(run=facts["run"]),
    }
    whole = {"style": _part("style.css"), "episodes": table if found else f"<p>{texts['empty']}</p>"}
    write_whole(folder / INDEX, _filled("index.html", values, whole))


def _data(folder: Path, about: Mapping[str, Any], texts: Mapping[str, Any]) -> Iterator[str]:
    """Yield the JSON of a page in parts, one step at a time, as an episode's images take megabytes."""
    instructions: list[str] = []
    yield '{"steps":['
    with (folder / STEPS).open(encoding="utf-8") as lines:
        for number, line in enumerate(lines):
            step = json.loads(line)
            if step["instruction"] not in instructions:
                instructions.append(step["instruction"])
            step["instruction"] = instructions.index(step["instruction"])
            for name in ("rgb", "depth"):
                if name in step:
                    step[name] = base64.b64encode((folder / step[name]).read_bytes()).decode("ascii")
            yield ("," if number else "") + _json(step)
    rest = {
        "instructions": [many_lines(each) for each in instructions],
        "poses": about["poses"],
        "obstacles": about.get("obstacles", []),
        "targets": about.get("targets", []),
        "texts": texts,
    }
    yield "]," + _json(rest)[1:]


def _json(content: object) -> str:
    """Encode JSON that is safe inside a script element, whatever its strings contain."""
    return json.dumps(content, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")


def _filled(name: str, values: Mapping[str, str], whole: Mapping[str, str]) -> str:
    """Fill in a page's template: `values` are escaped, the HTML parts in `whole` are inserted as they are."""
    pieces = _part(name).split("{{")
    filled = [pieces[0]]
    for piece in pieces[1:]:
        key, rest = piece.split("}}", 1)
        if key in whole:
            filled.append(whole[key])
        elif key in values:
            filled.append(html.escape(values[key]))
        else:
            filled.append("{{" + key + "}}")
        filled.append(rest)
    return "".join(filled)


def _cause(texts: Mapping[str, Any], about: Mapping[str, Any]) -> str:
    cause: str = texts.get(about["cause"] or "UNENDED", about["cause"])
    return cause


def _texts(language: str) -> tuple[str, Mapping[str, Any]]:
    """Return the language of the pages for a run in `language`, and the page texts in it."""
    found = _all_texts()
    language = language if language in found else _FALLBACK
    return language, found[language]


@cache
def _all_texts() -> Mapping[str, Mapping[str, Any]]:
    return tomllib.loads(_part("texts.toml"))


@cache
def _part(name: str) -> str:
    return (files("arramon_client.recording") / "pages" / name).read_text(encoding="utf-8")
