"""Registration with Gymnasium, under the project's namespace and without it.

Gymnasium looks for no plugins since its release 1.0: something has to import this package first.
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
"""Names of the environments, with what makes a single one and a vector of them."""


def register() -> None:
    """Register the environments; a second call does nothing."""
    for name, (single, vector) in ENTRY_POINTS.items():
        for id_ in (f"{NAMESPACE}/{name}", name):
            if id_ not in gymnasium.registry:
                gymnasium.register(id=id_, entry_point=single, vector_entry_point=vector)


class PlainSpec:
    """An environment whose `spec`, which Gymnasium sets, can be written as JSON. It must be the first base class.

    Paths are texts in it, numbers and arrays of NumPy Python's own. `access` is left out: a token does not belong in
    files, such as the data sets and videos that a spec is written to. A tokenizer that is an object stays one, and
    `to_json` refuses it.
    """

    _spec: EnvSpec | None = None

    @property
    def spec(self) -> EnvSpec | None:
        """How the environment was made; None if not by `gymnasium.make`."""
        return self._spec

    @spec.setter
    def spec(self, spec: EnvSpec | None) -> None:
        self._spec = None if spec is None else dataclasses.replace(spec, kwargs=plain_arguments(spec.kwargs))


def plain_arguments(arguments: dict[str, Any]) -> dict[str, Any]:
    """Return arguments without `access`, in types that JSON has."""
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
