"""Text encoder: matches of named and seen attributes, and independence of texts in a batch."""

import pytest

torch = pytest.importorskip("torch", reason="the extra `agents` is not installed: scripts/setup")

from torch import Tensor  # noqa: E402

from arramon_agents.perception.eyes.grid import CHANNEL_NAMES  # noqa: E402
from arramon_agents.perception.eyes.vocabulary import COLOURS  # noqa: E402
from arramon_agents.vl_grounded.attributes import KINDS, LOOKS, Attributes, attributes_of  # noqa: E402
from arramon_agents.vl_grounded.instruction_encoder import (  # noqa: E402
    Attention,
    AttributeProbabilities,
    InstructionEncoder,
    best_match,
    match,
)


def cell(**channels: float) -> Tensor:
    """Return the features of one cell, (1, C)."""
    values: Tensor = torch.zeros(1, len(CHANNEL_NAMES))
    for name, value in channels.items():
        values[0, CHANNEL_NAMES.index(name.replace("__", ":").replace("_colour", " colour"))] = value
    return values


def lit(there: Attributes) -> list[object]:
    """Return the names that are there for certain."""
    return [
        name
        for part, names in zip(there, (KINDS, COLOURS, LOOKS), strict=True)
        for name, value in zip(names, part[0].tolist(), strict=True)
        if value == 1.0
    ]


@pytest.mark.parametrize(
    ("channels", "names"),
    [
        ({"kind__mug": 1, "collectible": 1, "colour__red": 1, "pattern__dotted": 1},
         ["collectible", "mug", "red", ("pattern", "dotted")]),
        ({"furniture__banner": 1, "banner_colour__black": 1, "shape__star": 1}, ["banner", "black", ("shape", "star")]),
        ({"furniture__car": 1, "furniture_colour__gold": 1}, ["car", "gold"]),
        ({"facade__brick": 1}, ["building", "brick building"]),
        ({"start_tile": 1}, ["start_tile"]),
        ({"nearness": 1}, []),
    ],
)  # fmt: skip
def test_names_of_a_cell(channels: dict[str, float], names: list[object]) -> None:
    assert lit(attributes_of(cell(**channels))) == names


def meant(kind: str, colour: str = "", look: str = "") -> AttributeProbabilities:
    """Return what is meant by one read for certain, (1, 1, ...)."""
    parts = []
    for names, chosen in (
        ([*KINDS, ""], kind),
        ([*COLOURS, ""], colour),
        ([*(each[1] for each in LOOKS), ""], look),
    ):
        part = torch.zeros(1, 1, len(names))
        part[..., names.index(chosen)] = 1.0
        parts.append(part)
    return AttributeProbabilities(*parts)


@pytest.mark.parametrize(
    ("asked", "expected"),
    [
        (("mug", "red", "dotted"), [1, 0, 0, 0]),
        (("mug", "red"), [1, 1, 0, 0]),
        (("mug",), [1, 1, 1, 0]),
        (("collectible", "red"), [1, 1, 0, 0]),
        (("cone",), [0, 0, 0, 1]),
        (("",), [0, 0, 0, 0]),
    ],
)
def test_what_fits(asked: tuple[str, ...], expected: list[float]) -> None:
    mug = {"kind__mug": 1, "collectible": 1}
    cells = torch.cat(
        [
            cell(**mug, colour__red=1, pattern__dotted=1),
            cell(**mug, colour__red=1, pattern__striped=1),
            cell(**mug, colour__blue=1, pattern__dotted=1),
            cell(furniture__cone=1, furniture_colour__red=1),
        ]
    )
    there = Attributes(*(part[None] for part in attributes_of(cells)))
    assert match(meant(*asked), there)[0, 0].tolist() == expected


@pytest.mark.parametrize(("sure", "colour", "expected"), [(1.0, "red", 1.0), (0.5, "red", 0.125), (0.5, "", 0.125)])
def test_what_would_fit_best(sure: float, colour: str, expected: float) -> None:
    """A colour that is not told fits as well as one that is."""
    parts = [part * sure for part in meant("mug", colour, "dotted")]
    assert best_match(AttributeProbabilities(*parts)).tolist() == [[expected]]


def test_texts_of_a_batch_do_not_affect_each_other() -> None:
    torch.manual_seed(1)
    reading, attention = InstructionEncoder(20).eval(), Attention(4, 2).eval()
    texts = torch.tensor([[2, 3, 4, 5, 6], [7, 8, 0, 0, 0]])
    state = torch.randn(2, 4)
    words = reading(texts)
    found, looks = attention(state, words, texts == 0, attention.initial(texts))
    assert looks[1, :2, 2:].abs().max() == 0  # Nothing looks beyond a text's end.
    alone = texts[1:, :2]
    read, _ = attention(state[1:], reading(alone), alone == 0, attention.initial(alone))
    torch.testing.assert_close(found[1:], read)
