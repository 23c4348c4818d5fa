"""Settings of a collection, with the paper's values as defaults; fixed when it is created."""

import hashlib
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator

from arramon_server.errors import BadFile, BadInput

Stage = Literal["write", "verify"]
"""Stage of a worker's task; hosts have the further stage "review"."""

STAGES: tuple[Stage, ...] = ("write", "verify")

TABLE = "collections"
"""Table of the server's settings file with a table of settings for each collection."""

CONSENT = """\
You will write or follow short instructions in a simulated city. Your texts, the actions you take, the time you need and
the answers you give are stored under a pseudonym, and are used for research. Texts that are accepted are published in a
data set under the licence stated below, with the pseudonym. Your mail address, if you give one, is used only to tell
you about your texts, and is never published. You can stop at any time, and can delete your data on your own page.
"""
"""Default of `consent`. A host should replace it by a text that fits the law and the ethics board that apply."""

CONSENT_IN: Mapping[str, str] = {
    "hi": """\
आप एक बनावटी शहर में छोटे निर्देश लिखेंगे या दूसरों के निर्देशों के अनुसार चलेंगे। आपके लिखे निर्देश, आपका हर क़दम, लगा हुआ समय
और आपके जवाब आपके नाम के बिना, एक पहचान कोड के साथ रखे जाते हैं, और शोध में काम आते हैं। जो निर्देश स्वीकार होते हैं, वे उसी कोड के
साथ, नीचे बताए लाइसेंस के अंतर्गत एक डेटा-संग्रह में प्रकाशित होते हैं। अगर आप ईमेल पता देते हैं, तो वह केवल आपके निर्देशों के बारे में आपको बताने
के लिए है, और कभी प्रकाशित नहीं होता। आप कभी भी रुक सकते हैं, और अपने पन्ने पर अपना डेटा मिटा सकते हैं।
""",
}
"""The default consent text in other languages of the pages."""

CONSENT_LANGUAGE = "en"
"""Language of `consent`, which is shown where there is no translation."""

_Amount = Annotated[int, Field(ge=0, le=100_000_000)]
_Share = Annotated[float, Field(ge=0.0, le=1.0)]


class _Group(BaseModel):
    """Settings that are written and stored together; unknown names are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class DeviceRules(_Group):
    """What a worker's device must have before the first task.

    Attributes:
        keyboard_stages: stages that need a physical keyboard; others may be done by touch.
        min_width: minimum width of the window, in CSS pixels.
        max_frame_ms: maximum time of a frame in the measurement, from key to picture, in milliseconds.
    """

    keyboard_stages: tuple[Stage, ...] = ()
    min_width: int = Field(default=360, ge=200, le=4000)
    max_frame_ms: int = Field(default=1500, ge=50, le=60_000)


class SmtpSettings(_Group):
    """The server that sends mail to workers.

    Attributes:
        host, port: its address; an empty host sends no mail.
        sender: address in the field "From".
        security: "starttls" or "tls"; "none" is accepted for this machine only.
        user: user name; empty for none.
        password_file: path of a file, readable by its owner only, whose content is the password.
    """

    host: str = Field(default="", max_length=255)
    port: int = Field(default=587, ge=1, le=65_535)
    sender: str = Field(default="", max_length=320)
    security: Literal["starttls", "tls", "none"] = "starttls"
    user: str = Field(default="", max_length=320)
    password_file: str = ""


class PlatformStudy(_Group):
    """One study of a crowd platform.

    Attributes:
        stages: the stages that its workers do.
        tasks: number of submitted tasks after which a worker gets the completion code.
        code: the completion code.
        return_url: address that workers are sent to with it, such as "https://app.prolific.com/submissions/complete";
            `{code}` is replaced. Empty: the code is only shown.
    """

    stages: tuple[Stage, ...] = STAGES
    tasks: int = Field(default=1, ge=1, le=1000)
    code: str = Field(min_length=1, max_length=100)
    return_url: str = Field(default="", max_length=500)


class PlatformSettings(_Group):
    """Workers who come from a crowd platform.

    Attributes:
        key: secret that the address of every study contains (`key=...`), so that only the platform's workers join.
        studies: the studies by id.
    """

    key: str = Field(default="", max_length=200)
    studies: Mapping[str, PlatformStudy] = Field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class ConsentText:
    """A consent text as it is shown.

    Attributes:
        language: code of its language.
        text: the text.
    """

    language: str
    text: str

    def hash_with(self, licence: str) -> str:
        """Return the SHA-256 of text and licence, in hexadecimal."""
        return hashlib.sha256(f"{self.text}\n{licence}".encode()).hexdigest()


class Settings(_Group):
    """Settings of a collection. Amounts of money are in the currency's smallest unit, such as cents.

    Attributes:
        verifiers: number of workers who verify each text.
        keep_ndtw: a verifier succeeded only with more than this nDTW in both turns.
        keep_ptc: and with at least this PTC in both turns.
        keep_needs: number of verifiers who must succeed for a text to be kept.
        review_flags: number of verifiers who flag a text, from which a host reviews it before it is kept.
        pay_write, pay_verify: payment of a written text that was accepted, and of a verification.
        milestones: bonus by number of written texts that were accepted.
        pay_kept: bonus for each text that is kept.
        currency: three-letter code.
        currency_digits: number of decimal digits of the currency.
        screening_attempts: attempts at a screening test before a pause.
        screening_pause_minutes: the pause, after which the attempts start again.
        gold_share: share of known episodes among the verifications, for the figures of workers.
        gold_episodes: ids of these episodes; empty for all of the split that have texts in the language.
        min_seconds_write, min_seconds_verify: minimum active time of a task; faster verifications do not count, faster
            texts are reviewed.
        task_minutes: time without activity after which an open task goes back to the pool.
        max_tasks: maximum number of submitted tasks of a worker in each stage; 0 for no limit.
        max_characters: maximum length of one instruction.
        episodes: number of episodes of the split that are written for, in playing order; 0 for all.
        device: requirements for devices.
        page_languages: languages of the pages; empty for all that there are.
        licence: licence of the collected texts, as an SPDX identifier or in words.
        licence_address: address of the licence's text; empty for the known one of a Creative Commons licence, or none.
        consent: text that workers agree to, in English.
        consent_in: the same text by code of further languages of the pages. Pages of other languages show `consent`.
        smtp: the server for mail.
        platform: the crowd platform.
    """

    verifiers: int = Field(default=3, ge=1, le=20)
    keep_ndtw: _Share = 0.2
    keep_ptc: _Share = 1.0
    keep_needs: int = Field(default=1, ge=1, le=20)
    review_flags: int = Field(default=2, ge=1, le=21)
    pay_write: _Amount = 100
    pay_verify: _Amount = 20
    milestones: Mapping[int, _Amount] = Field(default_factory=lambda: {5: 10, 20: 90, 50: 400})
    pay_kept: _Amount = 10
    currency: str = Field(default="USD", pattern="^[A-Z]{3}$")
    currency_digits: int = Field(default=2, ge=0, le=3)
    screening_attempts: int = Field(default=2, ge=1, le=20)
    screening_pause_minutes: int = Field(default=60, ge=0, le=10_080)
    gold_share: Annotated[float, Field(ge=0.0, lt=1.0)] = 0.1
    gold_episodes: tuple[str, ...] = ()
    min_seconds_write: int = Field(default=60, ge=0, le=3600)
    min_seconds_verify: int = Field(default=20, ge=0, le=3600)
    task_minutes: int = Field(default=60, ge=1, le=10_080)
    max_tasks: int = Field(default=0, ge=0, le=1_000_000)
    max_characters: int = Field(default=1000, ge=50, le=10_000)
    episodes: int = Field(default=0, ge=0, le=1_000_000)
    device: DeviceRules = DeviceRules()
    page_languages: tuple[str, ...] = ()
    licence: str = Field(default="CC-BY-4.0", min_length=1, max_length=200)
    licence_address: str = Field(default="", max_length=500, pattern="^(https?://.*)?$")
    consent: str = Field(default=CONSENT, min_length=1, max_length=20_000)
    consent_in: Mapping[str, Annotated[str, Field(min_length=1, max_length=20_000)]] = Field(default_factory=dict)
    smtp: SmtpSettings = SmtpSettings()
    platform: PlatformSettings = PlatformSettings()

    @field_validator("milestones")
    @classmethod
    def _check_milestones(cls, value: Mapping[int, int]) -> Mapping[int, int]:
        if any(count < 1 for count in value):
            raise ValueError("a milestone is at less than 1 text")
        return dict(sorted(value.items()))

    @property
    def consent_hash(self) -> str:
        """SHA-256 of what workers agree to in English, text and licence, in hexadecimal."""
        return self.consent_shown(CONSENT_LANGUAGE).hash_with(self.licence)

    @property
    def consents(self) -> Mapping[str, str]:
        """The consent texts, by code of the language."""
        translated = CONSENT_IN if self.consent == CONSENT else {}
        return {**translated, **self.consent_in, CONSENT_LANGUAGE: self.consent}

    def consent_shown(self, language: str) -> "ConsentText":
        """Return the consent text on pages of a language, which is the English one if there is none in the language."""
        shown = language if language in self.consents else CONSENT_LANGUAGE
        return ConsentText(shown, self.consents[shown])

    def money(self, amount_minor: int) -> str:
        """Return an amount with its currency, such as "1.20 USD"."""
        return f"{decimal_amount(amount_minor, self.currency_digits)} {self.currency}"


def decimal_amount(amount_minor: int, digits: int) -> str:
    """Return an amount in the currency's main unit, exactly: 120 with 2 digits is "1.20"."""
    sign, size = "-" if amount_minor < 0 else "", abs(amount_minor)
    whole, rest = divmod(size, 10**digits)
    return f"{sign}{whole}.{rest:0{digits}d}" if digits else f"{sign}{whole}"


_AMOUNT = "a whole number of the currency's smallest unit from 0 to 100000000, such as 50 for 0.50 USD"

_EXPECTED: Mapping[str, str] = {
    "pay_write": _AMOUNT,
    "pay_verify": _AMOUNT,
    "pay_kept": _AMOUNT,
    "currency": "three capital letters, such as USD or INR",
    "consent": "one text of at most 20000 characters; the same text in other languages is `consent_in`, by their codes",
    "consent_in": 'texts of at most 20000 characters by code of their language, such as consent_in.hi = "..."',
}
"""What is expected of settings whose errors a library would not put into words that a host knows."""


def read_settings(given: Mapping[str, Any], origin: str) -> Settings:
    """Return the settings in a table.

    Args:
        given: the table, as read from TOML or JSON.
        origin: where it was read, for error messages.

    Raises:
        BadInput: naming the first setting that is wrong.
    """
    try:
        return Settings.model_validate(given)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        name = ".".join(map(str, first["loc"]))
        if first["type"] == "extra_forbidden":
            known = ", ".join(Settings.model_fields)
            raise BadInput(f"{origin}: there is no setting {name!r} of a collection; there are {known}") from None
        if (expected := _EXPECTED.get(str(first["loc"][0])) if first["loc"] else None) is not None:
            raise BadInput(f"{origin}: {name} is {first['input']!r}, expected {expected}") from None
        message = str(first["msg"]).removeprefix("Value error, ")
        raise BadInput(f"{origin}: {name} is {first['input']!r}: {message[:1].lower()}{message[1:]}") from None


def settings_in_file(path: Path) -> Settings:
    """Return the settings in a TOML file of their own.

    Raises:
        BadFile: if it cannot be read, or is not TOML.
        BadInput: if a setting is wrong.
    """
    return read_settings(_read_toml(path), str(path))


def settings_in_table(path: Path, name: str) -> tuple[Settings | None, tuple[str, ...]]:
    """Return the settings in the table `[collections.NAME]` of a server's settings file, and the names of all such.

    Args:
        path: the file.
        name: name of the collection; its settings are None if the file has no table of it.

    Raises:
        BadFile, BadInput: as for `settings_in_file`.
    """
    tables = _read_toml(path).get(TABLE, {})
    if not isinstance(tables, dict):
        raise BadFile(path, f"is {tables!r}, expected a table", field=TABLE)
    given = tables.get(name)
    if given is not None and not isinstance(given, dict):
        raise BadFile(path, f"is {given!r}, expected a table", field=f"{TABLE}.{name}")
    return (None if given is None else read_settings(given, f"{path}: [{TABLE}.{name}]")), tuple(tables)


def _read_toml(path: Path) -> dict[str, Any]:
    try:
        content: dict[str, Any] = tomllib.loads(path.read_text("utf-8"))
    except OSError as error:
        raise BadFile(path, f"cannot be read: {error.strerror}") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise BadFile(path, f"is not TOML: {error}") from error
    return content


def smtp_password(smtp: SmtpSettings) -> str:
    """Return the password in the file of the settings; empty if none is set.

    Raises:
        BadFile: if the file cannot be read, or others may read it.
    """
    if not smtp.password_file:
        return ""
    path = Path(smtp.password_file)
    try:
        mode = path.stat().st_mode
        content = path.read_text("utf-8")
    except OSError as error:
        raise BadFile(path, f"cannot be read: {error.strerror}") from error
    if mode & 0o077:
        raise BadFile(path, f"others may read it (mode {mode & 0o777:o}); expected mode 600")
    return content.strip("\r\n")
