"""Signature of a score: the settings that comparable scores must share, in one line as in sacrebleu."""

import hashlib
import re
from collections.abc import Collection, Iterable
from dataclasses import dataclass, replace
from urllib.parse import quote

_NONE = "none"


@dataclass(frozen=True, slots=True)
class Signature:
    """Settings that produced a score.

    `str()` returns the line to quote with a score, and `Signature.parse` reads it.

    Attributes:
        version: release of the server.
        protocol: version number of the protocol.
        split: name of the split, such as "val_seen".
        language: code of the language, such as "en".
        episodes: number of episodes in the denominator.
        steps_per_phase: step limit of a phase.
        clock: seconds of a step, of the first step and of the bank, such as "60/600/3600", or "none".
        sensors: sensors that the agent received.
        images: encodings and sizes in which images were sent, such as "lossless-224" and "jpeg90-128".
        data_hash: hash of the split's files, in hexadecimal.
        arguments: arguments that the agent was created with, each as written by `format_argument`.
        chosen: "" if the episodes are the first ones of the split in playing order, otherwise a hash of their ids.
        void: "" unless the host has voided episodes of the run, which then count in no score: a hash of their ids.

    Raises:
        ValueError: if a text is empty or contains a separator of the line.
    """

    version: str
    protocol: int
    split: str
    language: str
    episodes: int
    steps_per_phase: int
    clock: str
    sensors: frozenset[str]
    images: frozenset[str]
    data_hash: str
    arguments: frozenset[str] = frozenset()
    chosen: str = ""
    void: str = ""

    def __post_init__(self) -> None:
        """Reject values that could not be parsed again."""
        words = (self.version, self.split, self.language, self.clock, self.data_hash, *self.sensors, *self.images)
        hashes = [text for text in (self.chosen, self.void) if text]
        for text in (*words, *self.arguments, *hashes):
            if not text or any(mark.isspace() or mark in "|+" for mark in text):
                raise ValueError(f"{text!r} is not allowed in a signature: expected a word without '|', '+' or spaces")
        if _NONE in self.sensors | self.images | self.arguments:
            raise ValueError(f"{_NONE!r} is not allowed as a sensor, an encoding of images or an argument")

    def __str__(self) -> str:
        """Return the line, such as `split:val_seen|lang:en|episodes:1065|...`."""
        fields = {
            "split": self.split,
            "lang": self.language,
            "episodes": self.episodes,
            "steps": self.steps_per_phase,
            "clock": self.clock,
            "sensors": _joined(self.sensors),
            "images": _joined(self.images),
            "protocol": self.protocol,
            "version": self.version,
            "data": self.data_hash,
            **({"args": _joined(self.arguments)} if self.arguments else {}),
            **({"chosen": self.chosen} if self.chosen else {}),
            **({"void": self.void} if self.void else {}),
        }
        return "|".join(f"{key}:{value}" for key, value in fields.items())

    @classmethod
    def parse(cls, line: str) -> "Signature":
        """Parse a line.

        Raises:
            ValueError: if `str()` would not return the line; the message names what is wrong.
        """
        pairs = [part.split(":", 1) for part in line.strip().split("|")]
        fields = dict(pair for pair in pairs if len(pair) == 2)
        try:
            signature = cls(
                version=fields["version"],
                protocol=int(fields["protocol"]),
                split=fields["split"],
                language=fields["lang"],
                episodes=int(fields["episodes"]),
                steps_per_phase=int(fields["steps"]),
                clock=fields["clock"],
                sensors=_parted(fields["sensors"]),
                images=_parted(fields["images"]),
                data_hash=fields["data"],
                arguments=_parted(fields.get("args", _NONE)),
                chosen=fields.get("chosen", ""),
                void=fields.get("void", ""),
            )
        except KeyError as missing:
            raise ValueError(f"the signature {line!r} has no field {missing}") from None
        except ValueError as error:
            raise ValueError(f"the signature {line!r} cannot be read: {error}") from None
        if str(signature) != line.strip():
            raise ValueError(f"the signature {line!r} is not in canonical form: expected {str(signature)!r}")
        return signature


def episodes_digest(episode_ids: Iterable[str]) -> str:
    """Return the digest of a set of episodes in a signature: the first 12 digits of a hash of their ids."""
    return hashlib.sha256("\n".join(sorted(episode_ids)).encode()).hexdigest()[:12]


def without_episodes(line: str, voided: Collection[str]) -> str:
    """Return the line of a signature for scores without the void episodes.

    Args:
        line: signature of the scores of all episodes.
        voided: ids of those of its episodes that are void, at least one.
    """
    signature = Signature.parse(line)
    return str(replace(signature, episodes=signature.episodes - len(voided), void=episodes_digest(voided)))


def format_argument(name: str, value: str) -> str:
    """Format an argument for a signature: `name=value`, with white space, "%", "+" and "|" percent-encoded."""
    written = re.sub(r"[\s%+|]", lambda mark: quote(mark[0], safe=""), value)
    return f"{name}={written}"


def _joined(words: frozenset[str]) -> str:
    return "+".join(sorted(words)) or _NONE


def _parted(words: str) -> frozenset[str]:
    return frozenset() if words == _NONE else frozenset(words.split("+"))
