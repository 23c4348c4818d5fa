"""Labels of a segmentation as arrays."""

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np

from arramon_client.agent import Label
from arramon_client.environments import ArraMonEnv, FactoredLabels, factored

LABELS = (Label("road"), Label("mug", "red", "dotted"), Label("mug", "blue", "striped"), Label("wall", look="striped"))


def test_kind_colour_and_look_are_told_apart() -> None:
    found = factored(LABELS)

    assert (found.kinds, found.colours, found.looks) == (
        ("", "mug", "road", "wall"), ("", "blue", "red"), ("", "dotted", "striped")
    )  # fmt: skip
    assert found.table.tolist() == [[2, 0, 0], [1, 2, 1], [1, 1, 2], [3, 0, 2]]
    assert found.table.dtype == np.int16
    assert found.table[np.array([[3, 1]])].shape == (1, 2, 3)


def test_no_labels() -> None:
    found = factored(())

    assert (found.kinds, found.colours, found.looks) == (("",), ("",), ("",))
    assert found.table.shape == (0, 3)


def test_environments_have_them(data: Path) -> None:
    """Every pixel's factors are those of its label, in the single and in the vector environment."""
    given: dict[str, Any] = {"data": data, "split": "tiny", "sensors": ("segmentation",), "image_size": 64}
    env = gymnasium.make("arramon/ArraMon-v0", **given)
    single = env.unwrapped
    assert isinstance(single, ArraMonEnv)
    seen = env.reset(seed=0)[0]["segmentation"]
    found: FactoredLabels = single.factored_labels
    for number in np.unique(seen):
        kind, colour, look = found.table[number]
        assert Label(found.kinds[kind], found.colours[colour], found.looks[look]) == single.labels[number]
    assert len(np.unique(found.kind[seen])) > 1
    several: Any = gymnasium.make_vec("arramon/ArraMon-v0", 2, **given)
    assert (several.unwrapped.factored_labels.table == found.table).all()
    several.close()
    env.close()
