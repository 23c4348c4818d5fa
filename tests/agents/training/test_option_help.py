"""Help texts of training options."""

from dataclasses import dataclass, fields

import pytest

from arramon_agents.train import FIELDS_WITHOUT_OPTION, trainings
from arramon_agents.training.option_help import attribute_texts, option_help


@dataclass(frozen=True)
class Walking:
    """Settings of walking.

    Attributes:
        passes: number of epochs; half of them,
            50%, are short.
        sees, reads: whether it does.
        init: weights to start from.
    """

    passes: int = 4
    sees: bool = True
    reads: bool = True
    init: str = ""


@dataclass(frozen=True)
class Reading:
    """Settings of reading.

    Attributes:
        passes: number of epochs.
        languages: languages of the texts.

    More text.
    """

    passes: int = 3
    languages: tuple[str, ...] = ("en", "hi")


def test_texts_of_attributes() -> None:
    assert attribute_texts(Walking) == {
        "passes": "number of epochs; half of them, 50%, are short.",
        "sees": "whether it does.",
        "reads": "whether it does.",
        "init": "weights to start from.",
    }
    assert attribute_texts(Reading) == {"passes": "number of epochs.", "languages": "languages of the texts."}


@pytest.mark.parametrize(
    ("option", "recipes", "expected"),
    [
        ("init", {"walker": Walking()}, "weights to start from (default: none for walker)"),
        ("languages", {"reader": Reading()}, "languages of the texts (default: en,hi for reader)"),
        (
            "passes",
            {"walker": Walking(), "runner": Walking(), "racer": Walking(passes=9), "reader": Reading()},
            "number of epochs; half of them, 50%%, are short (default: 4 for walker, runner; 9 for racer); "
            "number of epochs (default: 3 for reader)",
        ),
    ],
)
def test_help_of_an_option(option: str, recipes: dict[str, object], expected: str) -> None:
    assert option_help(option, recipes) == expected


def test_every_option_is_described_by_every_recipe() -> None:
    for name, training in trainings().items():
        texts = attribute_texts(type(training.recipe))
        for field in fields(training.recipe):
            assert field.name in FIELDS_WITHOUT_OPTION or texts[field.name], (name, field.name)
