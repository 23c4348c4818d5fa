"""Definition of a setting: meaning, unit, range, and conversion of values from and to text.

A setting is a field of `arramon_server.configuration.config.Config`, created by `setting`. Its flag, environment
variable, key in the file, checks and row in the documentation all derive from that field.
"""

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, TypeVar, get_type_hints

from pydantic import BeforeValidator, Field, TypeAdapter, ValidationError

from arramon_server.configuration.secret_masking import mask_url
from arramon_server.errors import BadInput
from arramon_server.per_split import PerSplit
from arramon_server.split_times import SplitTimes

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class SettingDescription:
    """The description of a setting.

    Attributes:
        meaning: what it means, in one sentence.
        unit: unit of a number, such as "seconds".
        least, most: range of a number; None for no bound.
        choices: the values allowed; empty if they are not enumerable.
        form: form of a text, such as "host:port".
        check: returns whether a text has that form.
        secret: whether it may contain a password, which is masked when shown.
        internal: whether only the server's own processes use it, as a flag; it is in no file, variable or table.
        of_public_server: whether it says where a server is reached, and by whom and how often. A server that a client
            embeds takes it from flags only: its file and variables may be those of a public server.
    """

    meaning: str
    unit: str = ""
    least: float | None = None
    most: float | None = None
    choices: tuple[str, ...] = ()
    form: str = ""
    check: Callable[[str], bool] | None = None
    secret: bool = False
    internal: bool = False
    of_public_server: bool = False


def setting(default: T, meaning: str, **description: Any) -> T:
    """Return a dataclass field for a setting; `description` has further fields of its `SettingDescription`."""
    field: T = dataclasses.field(default=default, metadata={"description": SettingDescription(meaning, **description)})
    return field


@dataclass(frozen=True)
class Setting:
    """A setting with its name and type.

    Attributes:
        name: name of the field.
        type: type of its values.
        default: value if no source gives one.
        description: its description.
    """

    name: str
    type: Any
    default: Any
    description: SettingDescription

    @property
    def flag(self) -> str:
        """Command-line flag, such as `--bank-seconds`."""
        return "--" + self.name.replace("_", "-")

    @property
    def variable(self) -> str:
        """Environment variable, such as `ARRAMON_BANK_SECONDS`."""
        return "ARRAMON_" + self.name.upper()

    @property
    def is_switch(self) -> bool:
        """Whether it is a boolean."""
        return self.type in (bool, bool | None)

    @property
    def is_per_split(self) -> bool:
        """Whether each split may have a value of its own."""
        return self.type in (PerSplit, SplitTimes)

    @property
    def expected(self) -> str:
        """Accepted values, in words."""
        if self.description.choices:
            return "one of " + ", ".join(self.description.choices)
        if self.description.form:
            return self.description.form
        if self.is_switch:
            return "true or false"
        kinds = {int: "a whole number", PerSplit: "a whole number", float: "a number", tuple[int, ...]: "whole numbers"}
        words = kinds.get(self.type, "a path" if self.type in (Path, Path | None) else "a text")
        if self.description.unit:
            words += f" of {self.description.unit}"
        least, most = self.description.least, self.description.most
        if least is not None:
            words += f" from {as_text(least)}" + ("" if most is None else f" to {as_text(most)}")
        if self.type is SplitTimes:
            return "SPLIT=TIME, such as test_unseen=2030-12-01T12:00Z, separated by commas"
        if self.is_per_split:
            return words + ", or SPLIT=NUMBER, separated by commas"
        return words + (", separated by commas" if self.type == tuple[int, ...] else "")

    def parse(self, text: str, origin: str) -> Any:
        """Parse a text.

        Args:
            text: the text.
            origin: source of the text, for the error message.

        Raises:
            BadInput: if the text is not an accepted value.
        """
        try:
            value = self._adapter().validate_python(text)
        except ValidationError:
            value = None
        if self.type in (Path, Path | None) and not text:  # Path("") would be the working directory
            value = None
        fits = not self.description.choices or value in self.description.choices
        if self.description.check is not None and text:
            fits = fits and self.description.check(text)
        if value is None or not fits:
            shown = "invalid" if self.description.secret else repr(text)
            raise BadInput(f"{self.name} ({origin}) is {shown}, expected {self.expected}")
        return value

    def text(self, value: Any) -> str:
        """Return a value as text that `parse` accepts; empty for None."""
        return as_text(value)

    def masked_text(self, value: Any) -> str:
        """Return a value as text, with secrets masked."""
        return mask_url(self.text(value)) if self.description.secret else self.text(value)

    def _adapter(self) -> TypeAdapter[Any]:
        number = Field(ge=self.description.least, le=self.description.most)
        if self.type is float:
            number = Field(ge=self.description.least, le=self.description.most, allow_inf_nan=False)
        if self.type == tuple[int, ...]:
            return TypeAdapter(
                Annotated[tuple[Annotated[int, number], ...], Field(min_length=1), BeforeValidator(_parts)]
            )
        if self.type is SplitTimes:
            return TypeAdapter(Annotated[SplitTimes, BeforeValidator(SplitTimes.parse)])
        if self.is_per_split:
            return TypeAdapter(Annotated[PerSplit, BeforeValidator(self._per_split)])
        if self.type in (int, float):
            return TypeAdapter(Annotated[self.type, number])  # type: ignore[arg-type]
        return TypeAdapter(self.type)

    def _per_split(self, text: str) -> PerSplit:
        found = PerSplit.parse(text)
        if any(not _lies_within(number, self.description.least, self.description.most) for number in found.numbers):
            raise ValueError(text)
        return found


def settings_of(kind: type[Any]) -> Mapping[str, Setting]:
    """Return the settings of a dataclass by name, in order of definition."""
    types = get_type_hints(kind)
    return {
        field.name: Setting(field.name, types[field.name], field.default, field.metadata["description"])
        for field in dataclasses.fields(kind)
    }


def as_text(value: Any) -> str:
    """Return a value as text, in the form that every source accepts."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return repr(value).removesuffix(".0")
    if isinstance(value, Mapping):
        return ",".join(f"{name}={as_text(each)}" for name, each in value.items())
    return ",".join(map(as_text, value)) if isinstance(value, tuple | list) else str(value)


def _parts(value: Any) -> Any:
    return value.split(",") if isinstance(value, str) else value


def _lies_within(number: float, low: float | None, high: float | None) -> bool:
    return (low is None or number >= low) and (high is None or number <= high)
