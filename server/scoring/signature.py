"""A score's signature: what must be equal for two scores to be comparable, in one line (in sacrebleu's way)."""

from dataclasses import dataclass

_NONE = "none"


@dataclass(frozen=True, slots=True)
class Signature:
    """What a score was made with.

    `str()` gives the line to quote beside a score, and `Signature.parse` reads it back.

    Attributes:
        version: the server's release.
        protocol: the protocol's number.
        split: such as "val_seen".
        language: such as "en".
        episodes: how many were in the denominator.
        steps_per_phase: the step limit.
        clock: seconds of a step, of the first step and of the bank, such as "60/600/3600", or "none".
        sensors: that the agent was given.
        images: in which forms its images travelled, such as "lossless-224" and "jpeg90-128".
        data_hash: of the split's files, in hexadecimal.

    Raises:
        ValueError: for a text that is empty or holds what the line separates by.
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

    def __post_init__(self) -> None:
        """Refuse what could not be read back."""
        for text in (self.version, self.split, self.language, self.clock, self.data_hash, *self.sensors, *self.images):
            if not text or any(mark.isspace() or mark in "|+" for mark in text):
                raise ValueError(f"{text!r} cannot stand in a signature: expected a word without '|', '+' or spaces")
        if _NONE in self.sensors | self.images:
            raise ValueError(f"no sensor and no form of images can be called {_NONE!r}")

    def __str__(self) -> str:
        """The line, such as `split:val_seen|lang:en|episodes:1065|...`."""
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
        }
        return "|".join(f"{key}:{value}" for key, value in fields.items())

    @classmethod
    def parse(cls, line: str) -> "Signature":
        """The signature that a line stands for.

        Raises:
            ValueError: unless the line is one that `str()` gives; the message names what is wrong.
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
            )
        except KeyError as missing:
            raise ValueError(f"the signature {line!r} has no field {missing}") from None
        except ValueError as error:
            raise ValueError(f"the signature {line!r} cannot be read: {error}") from None
        if str(signature) != line.strip():
            raise ValueError(f"the signature {line!r} is not written as it should be: expected {str(signature)!r}")
        return signature


def _joined(words: frozenset[str]) -> str:
    return "+".join(sorted(words)) or _NONE


def _parted(words: str) -> frozenset[str]:
    return frozenset() if words == _NONE else frozenset(words.split("+"))
