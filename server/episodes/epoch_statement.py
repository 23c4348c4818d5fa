"""Epochs of hidden splits: their names, and the statement that a host commits to when it opens one.

An epoch is a split of its own, generated from a secret of its own. The host publishes its statement when it opens the
epoch: everything that determines the split, with the SHA-256 of the secret in place of the secret. The statement's
SHA-256 is the commitment, which is in the receipt of every run on the epoch.
"""

import hashlib
import re
from dataclasses import asdict, dataclass
from pathlib import Path

import rfc8785
from pydantic import TypeAdapter

from arramon_server.episodes.split_files import parse_json
from arramon_server.errors import BadFile, BadInput, quoted

FORMAT, VERSION = "arramon-epoch", 1

LIST_FORMAT, LIST_VERSION = "arramon-epochs", 1
"""Header of a file with the list of a host's epochs."""

SECRETS_FOLDER = "epochs"
"""Folder of the data folder with the secrets of epochs that are not revealed."""

SECRET_DIGITS = 64
"""Hexadecimal digits of a secret: 256 random bits."""

_NAME = re.compile(r"(?P<base>[a-z][a-z0-9_]*)_e(?P<number>[1-9][0-9]{0,5})")


@dataclass(frozen=True, slots=True)
class EpochStatement:
    """Statement that a host commits to when it opens an epoch.

    Attributes:
        split: name of the epoch's split, such as "test_unseen_e2".
        base: split of the data set that it is an epoch of.
        sections: ids of its sections.
        scale: share of the split's size, in (0, 1].
        episodes: number of its episodes.
        tried: whether an agent tried its instructions.
        generator: release of the project that generated it.
        sources: digest of the generator's code and data.
        data_hash: SHA-256 of the split's files.
        secret_sha256: SHA-256 of the secret, as `secret_digest` returns it.
        format: always "arramon-epoch".
        version: version of the statement's format.
    """

    split: str
    base: str
    sections: tuple[str, ...]
    scale: float
    episodes: int
    tried: bool
    generator: str
    sources: str
    data_hash: str
    secret_sha256: str
    format: str = FORMAT
    version: int = VERSION

    def canonical_json(self) -> bytes:
        """Return the statement as canonical JSON (RFC 8785)."""
        return rfc8785.dumps({**asdict(self), "sections": list(self.sections)})

    @property
    def command(self) -> str:
        """Command that regenerates the split, without the secret at its end."""
        untried = "" if self.tried else " --no-trial"
        return f"arramon-server generate --split {self.split} --scale {self.scale!r}{untried} --secret"


_STATEMENT = TypeAdapter(EpochStatement)


def read_statement(content: bytes, place: Path | str) -> EpochStatement:
    """Read a statement.

    Args:
        content: its canonical JSON.
        place: file or source, for messages.

    Raises:
        BadFile: if it is not a statement of this format, or not canonical JSON, so that its digest would differ.
    """
    statement = parse_json(_STATEMENT, content, Path(place))
    if (statement.format, statement.version) != (FORMAT, VERSION):
        problem = f"is {statement.format!r} version {statement.version}, expected {FORMAT!r} version {VERSION}"
        raise BadFile(place, problem, field="format")
    if parse_epoch_name(statement.split) is None or parse_epoch_name(statement.split) != (
        statement.base,
        epoch_number(statement.split),
    ):
        raise BadFile(place, f"is {statement.split!r}, expected an epoch of {statement.base!r}", field="split")
    if statement.canonical_json() != content:
        raise BadFile(place, "is not in canonical form (RFC 8785), so that its digest does not identify it")
    return statement


def commitment_of(statement: bytes) -> bytes:
    """Return the commitment to a statement: its SHA-256, 32 bytes."""
    return hashlib.sha256(statement).digest()


def secret_digest(secret: str) -> str:
    """Return the SHA-256 of a secret's 64 hexadecimal digits as text, in hexadecimal."""
    return hashlib.sha256(secret.encode()).hexdigest()


def check_secret(secret: str) -> str:
    """Check a typed secret, and return it without surrounding white space.

    Raises:
        BadInput: if it is not a secret; the message does not repeat it.
    """
    text = secret.strip()
    if len(text) != SECRET_DIGITS or not set(text) <= set("0123456789abcdef"):
        raise BadInput(f"the secret has {len(text)} characters, expected {SECRET_DIGITS} hexadecimal digits, 0 to f")
    return text


def epoch_split_name(base: str, number: int) -> str:
    """Return the name of an epoch's split."""
    return f"{base}_e{number}"


def parse_epoch_name(split: str) -> tuple[str, int] | None:
    """Parse the name of an epoch's split into base split and number; None for any other name."""
    found = _NAME.fullmatch(split)
    return (found["base"], int(found["number"])) if found else None


def epoch_number(split: str) -> int:
    """Return the number of an epoch from its split's name.

    Raises:
        BadInput: if it is not the name of an epoch's split.
    """
    found = parse_epoch_name(split)
    if found is None:
        raise BadInput(f"{quoted(split)} is not the name of an epoch, such as 'test_unseen_e1'")
    return found[1]
