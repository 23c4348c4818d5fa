"""`arramon-server film`: WebP, MP4 and HTML of an episode, and what it refuses."""

import json
import re
import sys
from contextlib import closing
from pathlib import Path

import pytest
from PIL import Image

from arramon_server import cli
from arramon_server.runs.storage import causes
from arramon_server.runs.storage.database import Database
from arramon_server.web.film.lettering import fitting, text_width, wrapped
from tests import tiny
from tests.played import play

RUN, HIDDEN_RUN, FORFEITED_RUN = "a" * 32, "b" * 32, "c" * 32
STEPS = len(tiny.ACTIONS)


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A data folder with runs on an open and a hidden split, and one that was given up at once."""
    folder = tmp_path_factory.mktemp("data")
    splits = [tiny.write(folder, count=2), tiny.write(folder, "secret", 1, hidden=True)]
    with closing(Database(f"sqlite:///{folder / 'journal.db'}")) as database:
        play(database, splits[0], RUN, {"0": tiny.ACTIONS, "1": tiny.ACTIONS})
        play(database, splits[1], HIDDEN_RUN, {"0": tiny.ACTIONS})
        play(database, splits[0], FORFEITED_RUN, {"0": ()}, ended={"0": causes.FORFEITED})
    return folder


class Films:
    """Makes films of a data folder's runs."""

    def __init__(self, data: Path, output: Path, capsys: pytest.CaptureFixture[str]) -> None:
        self._data, self._output, self._capsys = data, output, capsys

    def make(self, name: str, *more: str, run: str = RUN, episode: str = "0") -> tuple[int, str, str]:
        """Return the status, and what was printed to standard output and error."""
        self._capsys.readouterr()
        arguments = ["film", run, episode, "--data", str(self._data), "--output", str(self._output / name)]
        status = cli.main([*arguments, "--size", "96", *more])
        said = self._capsys.readouterr()
        return status, said.out, said.err


@pytest.fixture
def films(data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Films:
    return Films(data, tmp_path, capsys)


def test_webp_has_a_picture_for_each_step(films: Films, tmp_path: Path) -> None:
    status, out, err = films.make("x.webp", "--fps", "10")
    assert (status, err) == (0, "")
    assert f"x.webp: {STEPS + 1} pictures" in out
    with Image.open(tmp_path / "x.webp") as film:
        assert film.n_frames == STEPS + 1
        assert film.width >= 2 * 96
        film.load()
        assert film.info["duration"] == 100


def test_steps_are_chosen_and_labels_are_in_a_language(films: Films, tmp_path: Path) -> None:
    assert films.make("en.webp", "--steps", "2-4")[0] == 0
    assert films.make("hi.webp", "--steps", "2-4", "--lang", "hi")[0] == 0
    pictures = []
    for name in ("en.webp", "hi.webp"):
        with Image.open(tmp_path / name) as film:
            assert film.n_frames == 3
            pictures.append(film.convert("RGB").tobytes())
    assert pictures[0] != pictures[1]


def test_html_needs_nothing_else(films: Films, tmp_path: Path) -> None:
    status, _, err = films.make("x.html")
    assert (status, err) == (0, "")
    text = (tmp_path / "x.html").read_text(encoding="utf-8")
    assert re.findall(r'(?:src|href)="(?!data:|\?step=|#)([^"]*)"', text) == []
    assert re.findall(r'url\("(?!data:)', text) == []
    assert not re.search(r"^(?:import|export) ", text, re.MULTILINE)
    found = re.search(r'id="watch-film">(.*?)</script>', text, re.DOTALL)
    assert found is not None
    film = json.loads(found[1])
    assert len(film["frames"]) == len(film["data"]["moments"]) == STEPS + 1
    assert all(frame.startswith("data:image/jpeg;base64,") for frame in film["frames"])


def test_mp4_is_made_by_pyav(films: Films, tmp_path: Path) -> None:
    av = pytest.importorskip("av", reason="PyAV is not installed: pip install 'arramon-server[film]'")
    assert films.make("x.mp4", "--steps", "0-5")[0] == 0
    with av.open(str(tmp_path / "x.mp4")) as film:
        assert sum(1 for _ in film.decode(video=0)) == 6


def test_mp4_without_pyav_is_refused(films: Films, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "av", None)
    status, _, err = films.make("x.mp4")
    assert status == 1
    assert "MP4 needs PyAV, which is not installed: pip install 'arramon-server[film]'" in err
    assert not (tmp_path / "x.mp4").exists()


def test_the_host_may_film_hidden_splits(films: Films, tmp_path: Path) -> None:
    status, out, err = films.make("x.webp", "--steps", "0-1", run=HIDDEN_RUN)
    assert (status, "2 pictures" in out) == (0, True)
    assert "the split secret is hidden: this film shows what participants must not see" in err


@pytest.mark.parametrize(
    ("name", "more", "names", "message"),
    [
        ("x.gif", (), {}, "expected a file that ends with .webp, .mp4, .html"),
        ("x.webp", ("--steps", "4-2"), {}, "--steps is '4-2', expected the first and the last step"),
        ("x.webp", ("--steps", "x"), {}, "--steps is 'x', expected the first and the last step"),
        ("x.webp", ("--steps", "0-99"), {}, f"--steps ends with 99, expected at most {STEPS}"),
        ("x.webp", ("--lang", "fr"), {}, "--lang is 'fr', expected one of en, hi"),
        ("x.webp", (), {"run": "0" * 32}, "there is no run"),
        ("x.webp", (), {"episode": "9"}, "has no episode '9'"),
        ("x.webp", (), {"run": FORFEITED_RUN}, "has no steps yet"),
        ("no/such/folder/x.webp", ("--steps", "0-1"), {}, "No such file or directory"),
    ],
)
def test_what_is_wrong_is_named(
    films: Films, name: str, more: tuple[str, ...], names: dict[str, str], message: str
) -> None:
    status, out, err = films.make(name, *more, **names)
    assert (status, out) == (1, "")
    assert message in err
    assert "Traceback" not in err


@pytest.mark.parametrize("text", ["Turn left at the bench and go on", "बेंच के पास बाएँ मुड़ें और turn left करें"])
def test_lines_fit(text: str) -> None:
    lines = wrapped(text, 14, 120, 3)
    assert len(lines) <= 3
    assert all(text_width(line, 14) <= 120 for line in lines)
    assert fitting(text, 14, 80).endswith("...")
    assert wrapped(text, 14, 2000, 3) == [text]
