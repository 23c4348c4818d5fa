"""Generated room tasks: true texts in every language, and the same task for the same seed."""

import pytest

import arramon_lang as lang
from arramon_client.environments.backend import PlayerSettings
from arramon_client.errors import UsageError
from arramon_dataset.environments.random_rooms import draw_room, room_split
from arramon_server.episodes.instruction_texts import instructions_in
from tests.dataset.environments.players import player

SEEDS = range(20)


@pytest.mark.parametrize("language", ["en", "hi"])
def test_texts_are_within_what_was_announced_and_lead_to_the_cell(language: str) -> None:
    info = room_split(PlayerSettings(language, "drawn_rooms", (), 32))
    texts = info.texts[language]
    speech = lang.load(language)
    for seed in SEEDS:
        episode = draw_room(seed, language)
        for text in instructions_in([episode], language):
            assert set(text) <= set(texts.alphabet)
            assert len(text) <= texts.longest
            assert len(text.encode()) <= texts.longest_utf8
            assert speech.read(text, "assembly" if text == episode.instructions[language][0].assembly else "navigation")


def test_a_seed_gives_the_same_task_in_every_language() -> None:
    for seed in SEEDS:
        english, hindi = draw_room(seed, "en"), draw_room(seed, "hi")
        assert english == draw_room(seed, "en")
        assert (english.decoys, english.turns) == (hindi.decoys, hindi.turns)
    assert len({draw_room(seed, "en").decoys for seed in SEEDS}) == len(SEEDS)


def test_a_task_is_found_again_by_its_id() -> None:
    assert draw_room(0, "en", "room-7") == draw_room(7, "en")
    with pytest.raises(UsageError, match="the ids of drawn tasks are room-0, room-1"):
        draw_room(0, "en", "7")


def test_the_ground_truth_solves_them(tmp_path: object) -> None:
    from pathlib import Path

    made = player(Path(str(tmp_path)), "drawn_rooms", phases=("assembly",), expert="reference")
    for seed in SEEDS:
        seen = made.begin(None, seed)
        assert (seen.episode_id, seen.phase, seen.turn) == (f"room-{seed}", "assembly", 1)
        while not made.session.state.finished:
            made.step(made.expert_action())
        assert all(value == 1.0 for turn in made.session.scores().turns for value in turn.values())
