"""Parts of the pages that other packages add, by entry points."""

import logging
import sys
from importlib.metadata import EntryPoint
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

from arramon_server.episodes.split_lookup import SplitLookup
from arramon_server.web import web_parts
from arramon_server.web.page_texts import all_texts
from arramon_server.web.rendering import Renderer


def context() -> Any:
    """A context with what `open_parts` itself uses."""
    return SimpleNamespace(splits=SplitLookup({}))


def entries(monkeypatch: pytest.MonkeyPatch, **modules: str) -> None:
    found = [EntryPoint(name, module, web_parts.ENTRY_POINTS) for name, module in modules.items()]
    monkeypatch.setattr(web_parts, "entry_points", lambda group: found if group == web_parts.ENTRY_POINTS else [])


def test_a_part_is_opened_and_its_splits_are_found(monkeypatch: pytest.MonkeyPatch) -> None:
    module = ModuleType("part_of_a_test")
    part = SimpleNamespace(splits={"part/1": "a split"})
    module.open_part = lambda _: part  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "part_of_a_test", module)
    entries(monkeypatch, mine="part_of_a_test")
    lent = context()
    assert web_parts.open_parts(lent) == [part]
    assert lent.splits["part/1"] == "a split"


def test_a_part_that_lacks_a_package_is_left_out_with_a_warning(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    entries(monkeypatch, mine="no_such_package.part")
    with caplog.at_level(logging.WARNING):
        assert web_parts.open_parts(context()) == []
    assert "the pages 'mine' are left out: No module named 'no_such_package'" in caplog.text


def test_a_folder_has_templates_and_static_files_of_its_own(tmp_path: Path) -> None:
    for name, content in (
        (
            "templates/page.html",
            '{% extends "base.html" %}{% block content %}{{ static("own/own.css") }}{% endblock %}',
        ),
        ("static/own.css", "p { color: red; }"),
    ):
        (tmp_path / name).parent.mkdir()
        (tmp_path / name).write_text(content)
    renderer = Renderer()
    renderer.add_folder("own", tmp_path)
    shown = renderer.page("own/page.html", all_texts()["en"], "/", {}).decode()
    (address,) = [name for name in renderer.files if name.startswith("own.")]
    assert f"/static/{address}" in shown
    assert renderer.files[address] == (b"p { color: red; }", "text/css")
