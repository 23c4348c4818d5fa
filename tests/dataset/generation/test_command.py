"""Generation of whole splits: reproducibility, resuming, and failures."""

import stat
from dataclasses import replace
from pathlib import Path

import pytest

from arramon_dataset.generation import batches
from arramon_dataset.generation.batches import MakeWriter, make_batches
from arramon_dataset.generation.command import generate
from arramon_dataset.generation.split_maker import GenerationProgress
from arramon_dataset.generation.split_specs import SPLITS
from arramon_dataset.plans import build_section, read_plan
from arramon_server.episodes.split_secrets import host_secret
from arramon_server.episodes.splits import Split, read_split, split_folder
from arramon_server.errors import ArraMonError, BadInput
from tests.dataset.generation.small_section import CROSSING, make_failing_writer, make_picky_writer, make_plain_writer


def make(
    data: Path, *names: str, count: int = 4, seed: int = 1, jobs: int = 1, writer: MakeWriter = make_plain_writer
) -> tuple[list[Split], list[GenerationProgress]]:
    reported: list[GenerationProgress] = []
    plans = [SPLITS[name] for name in names]
    scale = count / plans[0].size
    return generate(
        data, plans, scale=scale, seed=seed, jobs=jobs, make_writer=writer, on_progress=reported.append
    ), reported


def files_of(data: Path) -> dict[str, bytes]:
    return {str(path.relative_to(data)): path.read_bytes() for path in sorted(data.rglob("*")) if path.is_file()}


def test_number_of_jobs_does_not_change_the_output(tmp_path: Path) -> None:
    make(tmp_path / "one", "val_unseen", count=7)
    make(tmp_path / "two", "val_unseen", count=7, jobs=2)

    assert files_of(tmp_path / "one") == files_of(tmp_path / "two")
    assert len(read_split(split_folder(tmp_path / "one", "val_unseen")).episodes) == 7


def test_another_seed_changes_episodes_and_furniture(tmp_path: Path) -> None:
    ((one,), (two,)) = (make(tmp_path / str(seed), "val_unseen", count=1, seed=seed)[0] for seed in (1, 2))

    assert list(one.episodes) == list(two.episodes)
    assert [episode.turns for episode in one.episodes.values()] != [episode.turns for episode in two.episodes.values()]
    assert one.sections["6"].props != two.sections["6"].props


def test_drafts_refused_by_the_writer_are_redrawn_and_counted(tmp_path: Path) -> None:
    (split,), reported = make(tmp_path, "val_unseen", count=7, writer=make_picky_writer)

    assert all(episode.turns[0].target.type.kind in ("ball", "mug", "tv") for episode in split.episodes.values())
    assert [(progress.done, progress.total) for progress in reported] == [(0, 7), (6, 7), (7, 7)]
    assert reported[-1].drafts > 7


def test_hidden_split_depends_only_on_the_hosts_secret(tmp_path: Path) -> None:
    """The public seed gives neither its episodes nor its section, and changes nothing; only its owner reads it."""
    (hidden,), _ = make(tmp_path / "host", "test_unseen", count=2, seed=1)
    (again,), _ = make(tmp_path / "host", "test_unseen", count=2, seed=2)
    (other,), _ = make(tmp_path / "other", "test_unseen", count=2, seed=1)
    sections = {"7": (read_plan("7"), build_section(read_plan("7"), "1"))}
    (batch,) = make_batches("1", "test_unseen", SPLITS["test_unseen"].episodes(2 / 1205), sections, make_plain_writer)
    public = {made.episode.episode_id: made.episode for made in batch.generate()}

    assert hidden.hidden
    assert hidden.episodes == again.episodes
    for elsewhere in (other.episodes, public):
        assert list(elsewhere) == list(hidden.episodes)
        for episode_id, episode in hidden.episodes.items():
            assert episode.turns != elsewhere[episode_id].turns
            assert episode.start != elsewhere[episode_id].start or episode.decoys != elsewhere[episode_id].decoys
    assert hidden.sections["7"].props != other.sections["7"].props
    assert stat.S_IMODE((tmp_path / "host" / "secret").stat().st_mode) == 0o600
    assert stat.S_IMODE(split_folder(tmp_path / "host", "test_unseen").stat().st_mode) == 0o700


def test_the_secret_is_in_no_other_file(tmp_path: Path) -> None:
    make(tmp_path, "test_unseen", count=2)
    secret = host_secret(tmp_path).encode()

    assert [name for name, data in files_of(tmp_path).items() if secret in data] == ["secret"]


@pytest.mark.parametrize("jobs", [1, 2])
def test_failed_generation_keeps_the_existing_split(tmp_path: Path, jobs: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(batches, "ATTEMPTS", 10)  # in this process
    make(tmp_path, "val_unseen", count=1)
    before = files_of(tmp_path)

    with pytest.raises(ArraMonError, match=r"no valid episode 55000 of split val_unseen found in \d+ attempts"):
        make(tmp_path, "val_unseen", count=2, jobs=jobs, writer=make_failing_writer)

    assert files_of(tmp_path) == before


def test_batches_are_grouped_by_section() -> None:
    sections = {name: (read_plan(name), replace(CROSSING, id=name)) for name in "12345"}
    batches = make_batches("1", "val_seen", SPLITS["val_seen"].episodes(40 / 1065), sections, make_plain_writer)

    assert [(batch.section.id, len(batch.episode_ids)) for batch in batches] == [
        (s, n) for s in "12345" for n in (6, 2)
    ]
    assert batches[0].episode_ids[:2] == ("5016", "5056")


@pytest.mark.parametrize("jobs", [-1, 257])
def test_jobs_out_of_range_are_refused(tmp_path: Path, jobs: int) -> None:
    with pytest.raises(BadInput, match="jobs"):
        make(tmp_path, "val_unseen", jobs=jobs)


def test_header_tells_that_no_agent_tried_the_texts(tmp_path: Path) -> None:
    plans, reported = [SPLITS["val_unseen"]], list[GenerationProgress]()
    (split,) = generate(
        tmp_path, plans, scale=0.0005, make_writer=make_plain_writer, on_progress=reported.append, jobs=1, tried=False
    )
    (tried,), _ = make(tmp_path, "val_unseen", count=1)

    assert split.source == "generated, scale 0.0005, seed 0, not tried by the follower"
    assert "tried" not in tried.source


def test_interrupted_split_is_finished_with_what_it_has(tmp_path: Path) -> None:
    """Of another seed, nothing is taken."""

    class Interrupted(Exception):
        pass

    def interrupt(progress: GenerationProgress) -> None:
        if progress.done:
            raise Interrupted

    def cut(data: Path) -> None:
        with pytest.raises(Interrupted):
            generate(
                data,
                [SPLITS["val_unseen"]],
                scale=8 / 1155,
                seed=1,
                jobs=1,
                make_writer=make_picky_writer,
                on_progress=interrupt,
            )

    cut(tmp_path / "cut")
    cut(tmp_path / "other")
    (split,), reported = make(tmp_path / "cut", "val_unseen", count=8, writer=make_picky_writer)
    (whole,), undisturbed = make(tmp_path / "whole", "val_unseen", count=8, writer=make_picky_writer)
    _, other = make(tmp_path / "other", "val_unseen", count=8, seed=2, writer=make_picky_writer)

    assert split.data_hash == whole.data_hash
    assert files_of(tmp_path / "cut") == files_of(tmp_path / "whole")
    assert [(progress.done, progress.kept) for progress in reported] == [(6, 6), (8, 6)]
    assert [(progress.done, progress.kept) for progress in other] == [(0, 0), (6, 0), (8, 0)]
    assert reported[-1].drafts == undisturbed[-1].drafts
    assert str(reported[0]) == "val_unseen: going on after 6 of 8 episodes"
