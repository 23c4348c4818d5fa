"""Cost of a run as declared by its publisher. The server cannot verify any of it."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from arramon_server.errors import BadInput

MAX_VALUE = 1e18
"""Largest number that can be declared."""


@dataclass(frozen=True, slots=True)
class Cost:
    """Declared cost of a run; fields that were not declared are None.

    Attributes:
        parameters: number of parameters of the agent's models.
        tokens: tokens that language models read and wrote in the whole run.
        price: price of the whole run, in US dollars.
    """

    parameters: int | None = None
    tokens: int | None = None
    price: float | None = None

    def __bool__(self) -> bool:
        """Return whether anything is declared."""
        return any(value is not None for value in (self.parameters, self.tokens, self.price))

    def check(self) -> None:
        """Check the numbers.

        Raises:
            BadInput: if one is negative, not finite or too large.
        """
        for name, value in asdict(self).items():
            if value is not None and not (math.isfinite(value) and 0 <= value <= MAX_VALUE):
                raise BadInput(f"the declared {name} is {value}; expected a number from 0 to {MAX_VALUE:.0e}")

    def to_stored(self) -> dict[str, Any] | None:
        """Return the cost as stored in the database; None if nothing is declared."""
        return {name: value for name, value in asdict(self).items() if value is not None} or None

    @classmethod
    def from_stored(cls, content: Mapping[str, Any] | None) -> "Cost":
        """Return the cost stored in the database."""
        return cls(**{name: content[name] for name in cls.__slots__ if name in content}) if content else cls()


NO_COST = Cost()


def mean_cost(costs: Sequence[Cost]) -> Cost:
    """Return the mean cost of several runs; each number is averaged over the runs that declare it."""

    def mean(name: str) -> float | None:
        declared = [value for value in (getattr(cost, name) for cost in costs) if value is not None]
        return sum(declared) / len(declared) if declared else None

    parameters, tokens = mean("parameters"), mean("tokens")
    return Cost(
        None if parameters is None else round(parameters), None if tokens is None else round(tokens), mean("price")
    )
