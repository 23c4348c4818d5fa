"""Registration of the environments with Gymnasium, with and without the project's namespace.

Since release 1.0 Gymnasium does not discover plugins: the package must be imported to be registered.
"""

import dataclasses
import os
from enum import Enum
from typing import Any

import gymnasium
import numpy as np
from gymnasium.envs.registration import EnvSpec

NAMESPACE = "arramon"
PACKAGE = "arramon_client.environments"

ENTRY_POINTS = {
    "ArraMon-v0": (f"{PACKAGE}.single:ArraMonEnv", f"{PACKAGE}.vector:make_vector"),
    "ArraMonRoom-v0": (f"{PACKAGE}.single:make_room", f"{PACKAGE}.vector:make_room_vector"),
}
"""Entry points of each environment, by name: of a single one and of a vector."""


def register() -> None:
    """Register the environments; a second call does nothing."""
    for name, (single, vector) in ENTRY_POINTS.items():
        for id_ in (f"{NAMESPACE}/{name}", name):
            if id_ not in gymnasium.registry:
                gymnasium.register(id=id_, entry_point=single, vector_entry_point=vector)


class PlainSpec:
    """Mixin that keeps an environment's `spec` serialisable as JSON. It must be the first base class.

    Paths become strings, and NumPy's numbers and arrays become Python's. `access` is left out: a token must not get
    into the files that a spec is written to, such as data sets and videos. A tokenizer object is kept, and `to_json`
    rejects it.
    """

    _spec: EnvSpec | None = None

    @property
    def spec(self) -> EnvSpec | None:
        """Gymnasium's specification of the environment; None if it was not made by `gymnasium.make`."""
        return self._spec

    @spec.setter
    def spec(self, spec: EnvSpec | None) -> None:
        self._spec = None if spec is None else dataclasses.replace(spec, kwargs=plain_arguments(spec.kwargs))


def plain_arguments(arguments: dict[str, Any]) -> dict[str, Any]:
    """Return the arguments without `access`, converted to types that JSON has."""
    return {name: _plain(value) for name, value in arguments.items() if name != "access"}


def _plain(value: object) -> object:
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    if isinstance(value, tuple | list):
        return [_plain(each) for each in value]
    if isinstance(value, Enum):
        return value.value
    return value
