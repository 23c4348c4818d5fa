"""Template variables of the host's page of one text: everything that is known of it."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from arramon_client.world import PHASES
from arramon_collecting.review.figures import outcome_of, walk_of
from arramon_collecting.review.text_maps import TextMaps, TurnMap, text_maps
from arramon_collecting.rules.agreement import agreement_of
from arramon_collecting.rules.flags import KINDS, kinds_by_part
from arramon_collecting.rules.keeping import decide, succeeded
from arramon_collecting.storage.records import REVIEW_KIND, Collection
from arramon_collecting.storage.texts.records import IN_REVIEW, Text, Verification
from arramon_collecting.web.review.host_view import percent, score
from arramon_server.episodes.splits import Split
from arramon_server.sim.room import START
from arramon_server.web.episodes_page import pile_name
from arramon_server.web.named_things import object_name
from arramon_server.web.page_texts import PageTexts
from arramon_server.web.room_map import cell_centre


@dataclass(frozen=True, slots=True)
class PartView:
    """One of the four instructions: name such as "1-navigation", text, failed checks in words, flags with numbers."""

    name: str
    phase: str
    text: str
    failures: tuple[str, ...]
    flags: tuple[tuple[str, int], ...]


@dataclass(frozen=True, slots=True)
class TurnView:
    """One turn; its map is None if the episode is not served."""

    number: int
    parts: tuple[PartView, ...]
    map: TurnMap | None


@dataclass(frozen=True, slots=True)
class WalkView:
    """A verification, whether it followed the text, and its flags in words."""

    row: Verification
    succeeded: bool
    flags: tuple[str, ...]


def text_context(
    t: PageTexts, collection: Collection, text: Text, verifications: Sequence[Verification], split: Split | None
) -> dict[str, Any]:
    """Return the template variables.

    Args:
        t: texts of the page's language.
        collection: the collection.
        text: the text.
        verifications: all of the text's, oldest first.
        split: the collection's split; None if it is not served.
    """
    maps = _maps(text, verifications, split)
    counted = [one for one in verifications if one.counts]
    agreement = agreement_of([walk_of(one) for one in counted if one.has_walk])
    is_decided = decide(list(map(outcome_of, counted)), collection.settings) is not None
    return {
        "text": text,
        "describes": maps is not None,
        "ground": maps.ground if maps is not None else None,
        "turns": [
            TurnView(
                number, _parts(t, text, verifications, number), maps.turns[number - 1] if maps is not None else None
            )
            for number in range(1, len(text.instructions) + 1)
        ],
        "walks": [
            WalkView(one, succeeded(outcome_of(one), collection.settings), _flag_words(t, one)) for one in verifications
        ],
        "agreement": None
        if agreement.path is None
        else {"path": score(t, agreement.path), "cell": percent(t, agreement.cell)},
        "evidence": sorted((t.named("collect_evidence", str(key)), str(value)) for key, value in text.evidence.items()),
        "may_decide": text.state == IN_REVIEW,
        "may_mend": text.state == IN_REVIEW and collection.kind == REVIEW_KIND,
        "accept_note": "keep" if text.worker_id is None or is_decided else "verify",
        "kinds": KINDS,
        "is_generated": text.worker_id is None,
        "start_tile": cell_centre(START),
        "object_name": lambda type_: object_name(t, type_),
        "pile_name": lambda pile: pile_name(t, pile),
    }


def _maps(text: Text, verifications: Sequence[Verification], split: Split | None) -> TextMaps | None:
    episode = split.episodes.get(text.episode_id) if split is not None else None
    if split is None or episode is None:
        return None
    return text_maps(episode, split.sections[episode.section], verifications)


def _parts(t: PageTexts, text: Text, verifications: Sequence[Verification], turn: int) -> tuple[PartView, ...]:
    counts = Counter(
        (part, kind) for one in verifications for part, kinds in kinds_by_part(one.flags).items() for kind in kinds
    )
    found = []
    for phase, said in zip(PHASES, text.instructions[turn - 1], strict=True):
        name = f"{turn}-{phase}"
        here = [one for one in text.failures if (one.get("turn"), one.get("phase")) == (turn, phase)]
        failures = tuple(_failure_words(t, failure) for failure in here)
        flags = tuple((kind, counts[name, kind]) for kind in KINDS if counts[name, kind])
        found.append(PartView(name, phase, said, failures, flags))
    return tuple(found)


def _failure_words(t: PageTexts, failure: Mapping[str, Any]) -> str:
    """Return what a failed check says, for a host; the stored English message for texts of earlier versions."""
    key = f"collect_host_checks.{failure['check']}"
    if key not in t.words or "words" not in failure:
        return str(failure["message"])
    words = ", ".join(f"“{word}”" for word in failure["words"])
    expected = str(failure["expected"])
    kind = t.named("things", expected).partition("|")[0] if failure["check"] == "not_there" else expected
    return t(key, words=words, expected=kind)


def _flag_words(t: PageTexts, verification: Verification) -> tuple[str, ...]:
    """Return the flags in words, such as "1 navigation: unclear"."""
    words = []
    for part, kinds in kinds_by_part(verification.flags).items():
        turn, _, phase = part.partition("-")
        said = ", ".join(t(f"collect_flags.{kind}") for kind in kinds)
        words.append(f"{t('collect_verify.part', turn=turn, phase=t(f'collect_verify.part_{phase}'))}: {said}")
    return tuple(words)
