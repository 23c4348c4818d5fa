"""Checkpoints of generation: resuming, locking, and damaged files."""

import stat
from pathlib import Path

import pytest

from arramon_dataset.generation.batches import GeneratedEpisode
from arramon_dataset.generation.checkpoint import GenerationCheckpoint, generation_digest
from arramon_server.errors import Conflict
from tests import tiny

MADE = [GeneratedEpisode(tiny.episode(str(number)), number + 1) for number in range(3)]


def kept(path: Path, origin: str = "here") -> list[GeneratedEpisode]:
    checkpoint = GenerationCheckpoint(path, origin)
    checkpoint.close()
    return list(checkpoint.episodes.values())


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """Of a checkpoint with all of `MADE`."""
    path = tmp_path / "unfinished" / "train.jsonl"
    checkpoint = GenerationCheckpoint(path, "here")
    checkpoint.add(MADE[:2])
    checkpoint.add(MADE[2:])
    checkpoint.close()
    return path


def test_episodes_are_kept_as_they_were(path: Path) -> None:
    assert kept(path) == MADE
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert stat.S_IMODE(path.parent.stat().st_mode) == 0o700


def test_episodes_of_another_origin_are_dropped(path: Path) -> None:
    assert kept(path, "elsewhere") == []
    assert kept(path, "here") == []


@pytest.mark.parametrize("end", [b'{"episode', b'{"episode": 1}\n', b"\0\0\0\n"])
def test_what_a_kill_left_at_the_end_is_cut_off(path: Path, end: bytes) -> None:
    whole = path.read_bytes()
    path.write_bytes(whole[:-1].rpartition(b"\n")[0] + b"\n" + end)
    checkpoint = GenerationCheckpoint(path, "here")
    checkpoint.add(MADE[2:])
    checkpoint.close()

    assert list(checkpoint.episodes.values()) == MADE[:2]
    assert path.read_bytes() == whole


@pytest.mark.parametrize("content", [b"", b"{", b"[]\n", b"\xff\n"])
def test_file_without_a_header_is_begun_anew(path: Path, content: bytes) -> None:
    whole = path.read_bytes()
    path.write_bytes(content)
    checkpoint = GenerationCheckpoint(path, "here")
    checkpoint.add(MADE)
    checkpoint.close()

    assert path.read_bytes() == whole


def test_one_process_at_a_time(path: Path) -> None:
    checkpoint = GenerationCheckpoint(path, "here")

    with pytest.raises(Conflict, match="another process is generating the split train in"):
        GenerationCheckpoint(path, "here")

    checkpoint.close()
    assert kept(path) == MADE


def test_removed_file_leaves_no_folder_unless_another_split_is_unfinished(path: Path) -> None:
    other = path.with_name("val_seen.jsonl")
    for each in (other, path):
        checkpoint = GenerationCheckpoint(each, "here")
        checkpoint.remove()
        checkpoint.close()
        assert path.parent.exists() == (each == other)


def test_origin_depends_on_each_part() -> None:
    assert generation_digest("1", "writer") == generation_digest("1", "writer")
    assert (
        len(
            {
                generation_digest("1", "writer"),
                generation_digest("2", "writer"),
                generation_digest("1", "other"),
                generation_digest("1"),
            }
        )
        == 4
    )
