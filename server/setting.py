"""What one setting of the server is: its meaning, unit and range, how it is read from text and shown as text.

A setting is a field of `server.config.Config`, made by `setting`. From the field alone come the flag, the environment
variable, the file's key, the checks and the documented table.
"""

import dataclasses
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, TypeVar, get_type_hints

from pydantic import BeforeValidator, Field, TypeAdapter, ValidationError

from server.errors import BadInput

T = TypeVar("T")

_SECRETS = (
    (re.compile(r"(://[^:/@\s]*:)[^/\s]*(@)"), r"\1***\2"),
    (re.compile(r"\b(arramon_[0-9A-Za-z]+_)[0-9A-Za-z_-]+"), r"\1***"),
    (re.compile(r"\b(bearer\s+)(?!arramon_)[^\s\"',]+", re.IGNORECASE), r"\1***"),
)
"""Passwords in URLs, tokens of participants, and whatever else is sent as one; each with what is put in its place."""


@dataclass(frozen=True, slots=True)
class Setting:
    """How a setting is described.

    Attributes:
        meaning: in one sentence, for people.
        unit: of a number, such as "seconds".
        least, most: of a number; None for no bound.
        choices: all that it may be; empty where there are others.
        form: of a text, such as "host:port"; with `check`, which says whether a text has it.
        secret: whether it may hold a password, which is then never shown.
        internal: whether it is only for the server's own processes, and in no file, variable or table.
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


def setting(default: T, meaning: str, **description: Any) -> T:
    """A field of a dataclass of settings; `description` as `Setting`."""
    field: T = dataclasses.field(default=default, metadata={"setting": Setting(meaning, **description)})
    return field


@dataclass(frozen=True)
class Named:
    """A setting of a dataclass, by its name.

    Attributes:
        type: of its values.
        default: where nobody gives it.
    """

    name: str
    type: Any
    default: Any
    setting: Setting

    @property
    def flag(self) -> str:
        """Such as `--idle-seconds`."""
        return "--" + self.name.replace("_", "-")

    @property
    def variable(self) -> str:
        """Such as `ARRAMON_IDLE_SECONDS`."""
        return "ARRAMON_" + self.name.upper()

    @property
    def is_switch(self) -> bool:
        """Whether it is on or off."""
        return self.type in (bool, bool | None)

    @property
    def expected(self) -> str:
        """What it takes, in words."""
        if self.setting.choices:
            return "one of " + ", ".join(self.setting.choices)
        if self.setting.form:
            return self.setting.form
        if self.is_switch:
            return "true or false"
        kinds = {int: "a whole number", float: "a number", tuple[int, ...]: "whole numbers"}
        words = kinds.get(self.type, "a path" if self.type in (Path, Path | None) else "a text")
        if self.setting.unit:
            words += f" of {self.setting.unit}"
        least, most = self.setting.least, self.setting.most
        if least is not None:
            words += f" from {as_text(least)}" + ("" if most is None else f" to {as_text(most)}")
        return words + (", with commas between" if self.type == tuple[int, ...] else "")

    def parse(self, text: str, origin: str) -> Any:
        """The value that a text stands for.

        Args:
            origin: where the text is from, for the error.

        Raises:
            BadInput: if the text is not what is expected.
        """
        try:
            value = self._adapter().validate_python(text)
        except ValidationError:
            value = None
        if self.type in (Path, Path | None) and not text:  # which Python takes for the working directory
            value = None
        fits = not self.setting.choices or value in self.setting.choices
        if self.setting.check is not None and text:
            fits = fits and self.setting.check(text)
        if value is None or not fits:
            shown = "something else" if self.setting.secret else repr(text)
            raise BadInput(f"{self.name} ({origin}) is {shown}, expected {self.expected}")
        return value

    def text(self, value: Any) -> str:
        """The text that stands for a value; empty for None."""
        return as_text(value)

    def shown(self, value: Any) -> str:
        """As `text`, without secrets."""
        return masked(self.text(value)) if self.setting.secret else self.text(value)

    def _adapter(self) -> TypeAdapter[Any]:
        number = Field(ge=self.setting.least, le=self.setting.most)
        if self.type is float:
            number = Field(ge=self.setting.least, le=self.setting.most, allow_inf_nan=False)
        if self.type == tuple[int, ...]:
            return TypeAdapter(
                Annotated[tuple[Annotated[int, number], ...], Field(min_length=1), BeforeValidator(_parts)]
            )
        if self.type in (int, float):
            return TypeAdapter(Annotated[self.type, number])  # type: ignore[arg-type]
        return TypeAdapter(self.type)


def settings_of(kind: type[Any]) -> Mapping[str, Named]:
    """The settings of a dataclass by name, in order."""
    types = get_type_hints(kind)
    return {
        field.name: Named(field.name, types[field.name], field.default, field.metadata["setting"])
        for field in dataclasses.fields(kind)
    }


def as_text(value: Any) -> str:
    """The text that stands for a value wherever it is given."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return repr(value).removesuffix(".0")
    return ",".join(map(as_text, value)) if isinstance(value, tuple | list) else str(value)


def masked(text: str) -> str:
    """A text without passwords in URLs, and without tokens."""
    for pattern, instead in _SECRETS:
        text = pattern.sub(instead, text)
    return text


def _parts(value: Any) -> Any:
    return value.split(",") if isinstance(value, str) else value
