"""The reader of plain demonstrations, and frames that are drawn on demand."""

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from arramon_client.demonstrations import Demonstrations
from arramon_client.environments import BadArgument
from arramon_client.errors import UsageError
from tests import tiny
from tests.dataset.demonstrations.exports import SIZE, expected_observations, export, playing_order


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("data")
    tiny.write(folder)
    return folder


@pytest.fixture(scope="module")
def folder(data: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("plain")
    export(data, folder, "plain")
    return folder


def test_it_reads_what_was_exported(data: Path, folder: Path) -> None:
    demonstrations = Demonstrations(folder)
    assert [one.episode_id for one in demonstrations] == playing_order(data, "en")
    assert demonstrations.settings["split"] == "tiny"
    for one in demonstrations[:3]:
        assert one.actions.tolist() == list(tiny.ACTIONS)
        assert (len(one), one.cause, one.finished) == (len(tiny.ACTIONS), "AGENT_FINISHED", True)
        assert one.scores["turn 2"]["PTC"] == 1.0
        for language in one.instructions:
            for step, expected in enumerate(expected_observations(data, one.episode_id, language, size=8)):
                assert tuple(one.poses[step]) == expected.pose
                assert one.turns[step] == expected.turn
                assert ("navigation", "assembly")[one.phases[step]] == expected.phase
                assert one.instruction(language, step) == expected.instruction


def test_frames_are_drawn_as_agents_see_them(data: Path, folder: Path) -> None:
    demonstrations = Demonstrations(folder)
    one = next(one for one in demonstrations if "hi" in one.instructions)
    drawn = list(demonstrations.draw(one, "hi", image_size=SIZE, data=data))
    assert [action for _, action in drawn] == list(tiny.ACTIONS)
    for (seen, _), expected in zip(drawn, expected_observations(data, one.episode_id, "hi"), strict=True):
        assert seen.rgb is not None
        assert seen.depth is not None
        assert (seen.rgb == expected.rgb).all()
        assert seen.depth.dtype == np.float32
        assert (seen.depth == expected.depth).all()
        assert seen.instruction == expected.instruction


def test_what_it_refuses(data: Path, folder: Path, tmp_path: Path) -> None:
    demonstrations = Demonstrations(folder)
    with pytest.raises(UsageError, match="has no instructions in 'fr'; it has en"):
        demonstrations[0].instruction("fr", 0)
    with pytest.raises(BadArgument, match="image_size is 33, expected a multiple of 8"):
        next(demonstrations.draw(demonstrations[0], "en", image_size=33, data=data))
    tiny.write(tmp_path, count=3)
    with pytest.raises(UsageError, match=r"the split 'tiny' here has the data .*, expected .*, from which"):
        next(demonstrations.draw(demonstrations[0], "en", data=tmp_path))
    with pytest.raises(UsageError, match="expected a folder that `export-demos` wrote"):
        Demonstrations(tmp_path)


def test_damaged_folders(folder: Path, tmp_path: Path) -> None:
    def copy(name: str) -> Path:
        shutil.copytree(folder, tmp_path / name)
        return tmp_path / name

    def change(name: str, **more: object) -> Path:
        damaged = copy(name)
        record = json.loads((damaged / "demonstrations.json").read_text())
        (damaged / "demonstrations.json").write_text(json.dumps({**record, **more}))
        return damaged

    settings = json.loads((folder / "demonstrations.json").read_text())["settings"]
    for damaged, said in (
        (change("other", format="else"), "is not of the format 'arramon-demonstrations', version 1"),
        (change("next", version=2), "is not of the format 'arramon-demonstrations', version 1"),
        (change("partial", complete=False), "is not complete; give the same `export-demos` command again"),
        (change("frames", settings={**settings, "format": "minari"}), "is in the format 'minari', expected 'plain'"),
    ):
        with pytest.raises(UsageError) as caught:
            Demonstrations(damaged)
        assert said in str(caught.value)
    missing = copy("missing")
    next(missing.glob("*.jsonl")).unlink()
    with pytest.raises(UsageError, match=r"files are missing in .*: expected 10 episodes, each language counted"):
        Demonstrations(missing)
    torn = copy("torn")
    path = next(torn.glob("*.jsonl"))
    path.write_text(path.read_text()[:-20])
    with pytest.raises(UsageError, match=r"jsonl:2: it is not JSON"):
        Demonstrations(torn)


@pytest.mark.parametrize(("change", "said"), [
    ({"actions": "0123"}, "its actions is '0123', expected a list"),
    ({"actions": [0, 1, 300, 2]}, "its actions are not numbers"),
    ({"actions": [0, 1, 7]}, "its turns are not numbers, 3"),
    ({"finished": "yes"}, "its finished is 'yes', expected a bool"),
    ({"episode_id": None}, "its episode_id is None, expected a str"),
    ({"poses": [["x"]]}, "its poses are not numbers"),
    ({"instructions": {"en": ["go"]}}, "its instructions in 'en' are not two texts for each of two turns"),
    ({"scores": []}, "its scores is [], expected a dict"),
    (None, "it is not an object"),
    ("[" * 200_000, "it is nested more than 64 levels deep"),
    ("{", "it is not JSON, or was truncated"),
])  # fmt: skip
def test_a_line_of_another_shape_is_refused_with_its_place(
    folder: Path, tmp_path: Path, change: dict[str, object] | str | None, said: str
) -> None:
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)
    path = next(tmp_path.glob("demonstrations-*.jsonl"))
    first, *rest = path.read_text().splitlines()
    changed = {**json.loads(first), **change} if isinstance(change, dict) else change
    line = changed if isinstance(changed, str) else json.dumps(changed)
    path.write_text("\n".join([rest[0] if rest else first, line]) + "\n")
    with pytest.raises(UsageError, match=re.escape(f"{path}:2: {said}")):
        Demonstrations(tmp_path)


@pytest.mark.parametrize(("record", "said"), [
    ("[" * 200_000, "nested more than 64 levels deep"),
    ('{"format": "arramon-demonstrations", "version": 1}', "has no settings"),
    ('{"format": "arramon-demonstrations", "version": 1, "settings": {}, "episodes_by_language": []}', "has no"),
])  # fmt: skip
def test_a_record_of_another_shape_is_refused(tmp_path: Path, record: str, said: str) -> None:
    (tmp_path / "demonstrations.json").write_text(record)
    with pytest.raises(UsageError, match=said):
        Demonstrations(tmp_path)
