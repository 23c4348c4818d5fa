"""Sections with random street plans, and the split generated in them."""

from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest

from arramon_dataset.generation.command import generate
from arramon_dataset.generation.extra_sections import extra_sections
from arramon_dataset.generation.split_maker import GenerationProgress
from arramon_dataset.generation.split_specs import EXTRA, SPLITS, extra_spec, select_specs
from arramon_dataset.plans.faults import faults_of_plan, faults_of_section
from arramon_server.cli import main
from arramon_server.episodes.splits import read_split, split_folder
from arramon_server.errors import BadInput
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.runs.play.worlds import Worlds
from arramon_server.sim.rules import Limits
from tests.dataset.generation.small_section import make_plain_writer
from tests.dataset.plans.sections import SEED, plan_of, section_of


def test_another_seed_or_id_gives_another_plan() -> None:
    one, other = (extra_sections(SEED, [name])[name] for name in ("101", "102"))
    (elsewhere,) = extra_sections("another seed", ["101"]).values()

    assert one[0].streets != other[0].streets
    assert one[0].streets != elsewhere[0].streets
    assert extra_sections(SEED, ["101"])["101"] == one


@pytest.mark.parametrize("section_id", ["1", "4", "101"])
def test_sections_by_hand_and_drawn_ones_have_no_faults(section_id: str) -> None:
    plan, section = plan_of(section_id), section_of(section_id)

    assert faults_of_plan(plan) == ()
    assert faults_of_section(plan, section) == ()


def test_faults_are_found() -> None:
    plan, section = plan_of("101"), section_of("101")
    middle = plan.streets[0].points[0]
    wall = replace(section.buildings[0], x=plan.origin[0], z=plan.origin[1], half_width=30.0, half_length=1.0)
    wide = replace(plan, streets=(replace(plan.streets[0], points=(middle, (middle[0] + 60.0, middle[1] + 9.0))),))

    assert "a street is not free, or leads nowhere" in faults_of_section(
        plan, replace(section, buildings=(*section.buildings, wall))
    )
    assert "it is open to the outside" in faults_of_section(plan, replace(section, buildings=section.buildings[20:]))
    assert any("props" in fault for fault in faults_of_section(plan, replace(section, props=section.props[:60])))
    assert len(faults_of_plan(wide)) == 1


def test_the_split_is_for_training_alone(tmp_path: Path) -> None:
    """It is in sections of its own, with ids that no other split has."""
    reported: list[GenerationProgress] = []
    plans = select_specs([EXTRA], 2)
    (split,) = generate(
        tmp_path, plans, scale=4 / 1706, seed=3, jobs=1, make_writer=make_plain_writer, on_progress=reported.append
    )

    assert split.training
    assert read_split(split_folder(tmp_path, EXTRA)).training
    assert list(split.sections) == ["101", "102"]
    assert [episode.section for episode in split.episodes.values()] == ["101", "101", "102", "102"]
    papers = {name for plan in SPLITS.values() for name, _ in plan.episodes()}
    assert papers.isdisjoint(name for name, _ in extra_spec(1000).episodes())


@pytest.mark.slow
def test_the_command_makes_episodes_with_instructions_to_learn_from(tmp_path: Path) -> None:
    """With the real writer, gate and trial: two episodes in each of two sections, whose ground truth is perfect."""
    command = ["generate", "--data", str(tmp_path), "--split", EXTRA, "--sections", "2", "--scale", str(4 / 1706)]
    assert main([*command, "--jobs", "1"]) == 0
    split = read_split(split_folder(tmp_path, EXTRA))

    assert split.training
    assert split.languages.keys() == {"en", "hi"}
    assert [episode.section for episode in split.episodes.values()] == ["101", "101", "102", "102"]
    with closing(Worlds({EXTRA: split})) as worlds:
        for episode in split.episodes.values():
            session = EpisodeSession(episode, worlds.world(EXTRA, episode), Limits())
            list(session.replay(action for turn in episode.turns for action in (*turn.actions, *turn.room_actions)))
            assert session.cause == "AGENT_FINISHED"
            assert min(scores[name] for scores in session.scores().turns for name in ("nDTW", "CTC-3", "PTC")) > 0.999
            texts = [
                text
                for turns in episode.instructions.values()
                for one in turns
                for text in (one.navigation, one.assembly)
            ]
            assert len(set(texts)) == 8


@pytest.mark.parametrize(
    ("names", "sections", "words"),
    [
        (["train_extra"], None, "needs a number of sections: give it with --sections"),
        (["train_extra"], 0, "the number of sections is 0; expected 1 to 1000"),
        (["train_extra"], 1001, "the number of sections is 1001"),
        (["train"], 3, "--sections applies to the split 'train_extra' only"),
        (None, 3, "--sections applies to the split 'train_extra' only"),
        (["extra"], None, "there is no split 'extra'; there are train, val_seen, val_unseen, test_unseen, train_extra"),
    ],
)
def test_wrong_names_and_numbers_are_refused(names: list[str] | None, sections: int | None, words: str) -> None:
    with pytest.raises(BadInput, match=words):
        select_specs(names, sections)


def test_they_are_never_among_the_papers_splits() -> None:
    assert [plan.name for plan in select_specs(None)] == ["train", "val_seen", "val_unseen", "test_unseen"]
    assert [plan.name for plan in select_specs(["train_extra", "train"], 2)] == ["train", "train_extra"]
