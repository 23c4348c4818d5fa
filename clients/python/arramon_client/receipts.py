"""Receipt files: writing, reading and verification, against the host's key and the actions sent."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey
from cryptography.hazmat.primitives.serialization import load_pem_public_key

from arramon.strict_json import NotJsonError, read_json
from arramon.v1 import evaluation_pb2
from arramon.v1.chain import episode_head, run_digest, steps_to
from arramon_client.errors import ReceiptError
from arramon_client.files import write_whole
from arramon_client.notices import digest_of
from arramon_client.printable import to_json
from arramon_client.transport.incoming import check_run_id

FILE_FORMAT, FILE_VERSION = "arramon-receipt-file", 1
FORMAT, VERSION, MASKED_VERSION = "arramon-receipt", 1, 2
"""Header of the payload; MASKED_VERSION is for hidden splits, for which earlier releases used VERSION, too."""

SUFFIX = ".receipt.json"
"""Suffix of a receipt's file, which is in the same folder as the run's results file."""

KEY_BYTES, SIGNATURE_BYTES = 32, 64


NUMBER, ANY_KEY = (int, float), "*"

MAX_NUMBER = 2**53
"""Largest number in a receipt: JSON readers may round larger ones."""

REQUIRED_FIELDS = {
    "run": {
        **dict.fromkeys(("run_id", "participant", "agent", "split", "language", "state", "created_at"), str),
        "ended_at": (str, type(None)),
        "code": (dict, type(None)),
    },
    "limits": dict.fromkeys(("steps_per_phase", "step_seconds", "bank_seconds"), NUMBER),
    "data_hash": str,
    "score_signature": str,
    "causes": {ANY_KEY: int},
    "reoffers": int,
    "scores": {ANY_KEY: {ANY_KEY: dict.fromkeys(("mean", "low", "high"), NUMBER)}},
    "episodes": [{"episode_id": str, "head": str}],
    "digest": str,
    "epoch": (str, type(None)),
}
"""Fields that every receipt must have, with their types; a valid signature does not guarantee them."""

VERSION_FIELDS = {
    VERSION: {"steps": int, "episodes": [{"cause": str, "steps": int}]},
    MASKED_VERSION: {"episodes": [{"ending": str}]},
}
"""Further required fields, by version."""

OPTIONAL_FIELDS = {
    "corrections": [{"kind": str, "made_at": str, "reason": str, "episodes": [str]}],
    "revision": {"number": int, "made_at": str, "supersedes": str},
    "voided": [str],
}
"""Optional fields, with their types."""


@dataclass(frozen=True)
class Receipt:
    """A receipt with a valid signature by the public key that it contains.

    Attributes:
        public_key: 32 bytes; trust it only if it is the host's key.
        content: the signed content as plain data, described in `docs/reference/receipts.md`.
        digest: SHA-256 of the signed content, 32 bytes.
        payload: the signed content as text.
        signature: the signature of the payload, 64 bytes.
    """

    public_key: bytes
    content: Mapping[str, Any]
    digest: bytes = b""
    payload: str = field(default="", repr=False)
    signature: bytes = field(default=b"", repr=False)

    @property
    def run(self) -> Mapping[str, Any]:
        """The run's id, participant, agent, split, language, state and times."""
        run: Mapping[str, Any] = self.content["run"]
        return run

    @property
    def episodes(self) -> Sequence[Mapping[str, Any]]:
        """The run's episodes, in playing order."""
        episodes: Sequence[Mapping[str, Any]] = self.content["episodes"]
        return episodes

    def file_content(self) -> dict[str, Any]:
        """Return the content of the receipt's file, which `arramon-client verify` checks when it is written as JSON."""
        return _file_content(self.payload, self.signature, self.public_key)


def write_receipt(receipt: evaluation_pb2.Receipt, run_id: str, folder: Path) -> Path:
    """Write `<folder>/<run id>.receipt.json` atomically.

    Returns:
        The path of the file.

    Raises:
        OutputError: if it cannot be written.
        ReceiptError: if its payload is not text.
    """
    check_run_id(run_id)
    try:
        payload = receipt.payload.decode()
    except UnicodeDecodeError as error:
        raise ReceiptError(f"the receipt of run {run_id} is not text: {error}") from error
    path = folder / f"{run_id}{SUFFIX}"
    write_whole(path, to_json(_file_content(payload, receipt.signature, receipt.public_key)))
    return path


def _file_content(payload: str, signature: bytes, public_key: bytes) -> dict[str, Any]:
    return {
        "format": FILE_FORMAT,
        "version": FILE_VERSION,
        "payload": payload,
        "signature": signature.hex(),
        "public_key": public_key.hex(),
    }


def read_file(path: Path, kind: str) -> Any:
    """Return the JSON content of a file.

    Args:
        path: the file.
        kind: the kind of file expected, for the message, for example "receipt".

    Raises:
        ReceiptError: if it cannot be read, or is not JSON.
    """
    try:
        return read_json(path.read_bytes())
    except OSError as error:
        raise ReceiptError(f"{path} cannot be read: {error.strerror or error}") from error
    except NotJsonError as error:
        raise ReceiptError(f"{path} is not a {kind}: it {error}") from error


def read_receipt(path: Path) -> Receipt:
    """Read a receipt from its file, and verify its signature and digest.

    Raises:
        ReceiptError: if it cannot be read, or was altered.
    """
    content = read_file(path, "receipt")
    _check_format(path, content, FILE_FORMAT, FILE_VERSION)
    payload = content.get("payload")
    if not isinstance(payload, str):
        raise ReceiptError(f"{path} is not a receipt: it has no payload")
    signature = _bytes(path, content, "signature", SIGNATURE_BYTES)
    key = _bytes(path, content, "public_key", KEY_BYTES)
    return _checked(path, payload, signature, key)


def receipt_of(message: evaluation_pb2.Receipt, run_id: str) -> Receipt:
    """Return a run's receipt as the server sent it, after verifying its signature and digest.

    Raises:
        ReceiptError: if it was altered.
    """
    where = f"the receipt of run {run_id}"
    try:
        payload = message.payload.decode()
    except UnicodeDecodeError as error:
        raise ReceiptError(f"{where} is not text: {error}") from error
    return _checked(where, payload, message.signature, message.public_key)


def read_key(text: str) -> bytes:
    """Return a host's public key, 32 bytes.

    Args:
        text: the key in hexadecimal, or the path of a file that contains it in hexadecimal or PEM.

    Raises:
        ReceiptError: if it is none of these.
    """
    content = text
    if not _is_hexadecimal(text):
        try:
            content = Path(text).read_text("utf-8-sig").strip()
        except (OSError, UnicodeDecodeError) as error:
            raise ReceiptError(f"{text} is neither a hexadecimal key nor a readable file: {error}") from error
    if _is_hexadecimal(content):
        return bytes.fromhex(content)
    try:
        key = load_pem_public_key(content.encode())
    except ValueError:
        key = None
    if not isinstance(key, Ed25519PublicKey):
        raise ReceiptError(
            f"{text} contains no public key: expected {2 * KEY_BYTES} hexadecimal digits, or Ed25519 in PEM"
        )
    return key.public_bytes_raw()


def check_key(receipt: Receipt, key: bytes, whose: str) -> None:
    """Check that a receipt was signed with the expected key.

    Args:
        receipt: the receipt.
        key: the expected public key, 32 bytes.
        whose: description of the expected key, for the message.

    Raises:
        ReceiptError: if it was signed with another key.
    """
    if receipt.public_key != key:
        raise ReceiptError(
            f"the receipt is signed with the key {receipt.public_key.hex()}, not with {whose}, {key.hex()}. "
            "If the host has changed its key, ask the host for the previous one"
        )


@dataclass(frozen=True)
class Comparison:
    """Comparison of a receipt's actions with those that a client sent.

    Attributes:
        same: number of episodes with the same actions.
        differences: a sentence for each episode with different actions, in the receipt's order.
    """

    same: int
    differences: tuple[str, ...]


def compare_actions(receipt: Receipt, actions: Mapping[str, Sequence[int]]) -> Comparison:
    """Compare the episodes of a receipt with the actions that a client sent.

    Args:
        receipt: the run's receipt.
        actions: actions by episode id, from the first step on; actions beyond the episode's end are ignored, and
            episodes that are not contained are not compared.
    """
    found = [
        (episode["episode_id"], _difference(receipt, episode, actions[episode["episode_id"]]))
        for episode in receipt.episodes
        if episode["episode_id"] in actions
    ]
    differences = tuple(f"episode {episode_id}: {said}" for episode_id, said in found if said)
    return Comparison(len(found) - len(differences), differences)


def _difference(receipt: Receipt, episode: Mapping[str, Any], sent: Sequence[int]) -> str:
    """Describe the difference in one episode; empty if there is none."""
    names = receipt.run["run_id"], episode["episode_id"], receipt.content["data_hash"]
    steps = episode.get("steps")
    if steps is None:  # A hidden split's receipt does not reveal it.
        steps = steps_to(bytes.fromhex(episode["head"]), *names, sent)
        return "" if steps is not None else _OTHER_ACTIONS
    if len(sent) < steps:
        return f"the receipt has {steps} steps, but this client sent {len(sent)}"
    return "" if episode_head(*names, sent[:steps]).hex() == episode["head"] else _OTHER_ACTIONS


_OTHER_ACTIONS = "the receipt's actions differ from those that this client sent"


def _checked(path: Path | str, payload: str, signature: bytes, key: bytes) -> Receipt:
    try:
        Ed25519PublicKey.from_public_bytes(key).verify(signature, payload.encode())
    except (InvalidSignature, ValueError) as error:  # ValueError: the payload cannot be encoded in UTF-8
        raise ReceiptError(f"{path} was altered: its signature does not match its content and key") from error
    try:
        content = read_json(payload)
    except NotJsonError:
        content = None
    _check_format(path, content, FORMAT, *VERSION_FIELDS)
    further = {name: shape for name, shape in OPTIONAL_FIELDS.items() if name in content}
    if not (_fits({**REQUIRED_FIELDS, **further}, content) and _fits(VERSION_FIELDS[content["version"]], content)):
        raise ReceiptError(f"{path} is signed, but its content does not have the fields of a receipt")
    receipt = Receipt(key, content, digest_of(payload), payload, signature)
    heads = [(episode["episode_id"], _bytes(path, episode, "head", 32)) for episode in receipt.episodes]
    if run_digest(receipt.run["run_id"], heads).hex() != content["digest"]:
        raise ReceiptError(f"{path} is inconsistent: its digest does not match its episodes")
    return receipt


def _check_format(path: Path | str, content: Any, name: str, *versions: int) -> None:
    if not isinstance(content, dict) or content.get("format") != name:
        raise ReceiptError(f"{path} is not a receipt: it does not have the format {name!r}")
    version = content.get("version")
    if isinstance(version, bool) or version not in versions:
        reads = " and ".join(map(str, versions))
        raise ReceiptError(f"{path} has {name} version {version!r}, but this client reads version {reads}")


def _fits(shape: Any, value: Any) -> bool:
    if isinstance(shape, list):
        return isinstance(value, list) and all(_fits(shape[0], each) for each in value)
    if not isinstance(shape, dict):
        if isinstance(value, float | int) and not isinstance(value, bool):
            return isinstance(value, shape) and abs(value) <= MAX_NUMBER
        return isinstance(value, shape) and not isinstance(value, bool)
    if not isinstance(value, dict):
        return False
    if ANY_KEY in shape:
        return all(_fits(shape[ANY_KEY], each) for each in value.values())
    return all(_fits(each, value.get(name)) for name, each in shape.items())


def _bytes(path: Path | str, content: Mapping[str, Any], name: str, length: int) -> bytes:
    text = content.get(name)
    try:
        found = bytes.fromhex(text) if isinstance(text, str) else b""
    except ValueError:
        found = b""
    if len(found) != length:
        raise ReceiptError(f"{path} is not a receipt: its {name} is not {length} bytes in hexadecimal")
    return found


def _is_hexadecimal(text: str) -> bool:
    return len(text) == 2 * KEY_BYTES and set(text.lower()) <= set("0123456789abcdef")
