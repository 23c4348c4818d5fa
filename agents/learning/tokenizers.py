"""Tokenizers of trained agents, by name: "word", "sentencepiece", "xlmr". 0 is padding, 1 an unknown piece.

All normalise to NFC and drop zero-width joiners first, so that one spelling of a Hindi word has one form.
"""

import json
import tempfile
import unicodedata
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, Protocol

from arramon_client.words import words

PAD, UNKNOWN, SPECIAL = 0, 1, 2
"""Padding; an unknown piece; the number of these."""

PIECES = 1000
"""Pieces of a SentencePiece model, unless the texts give fewer."""

_JOINERS = {0x200C: None, 0x200D: None}


class Tokenizer(Protocol):
    """Turns texts into numbers.

    Attributes:
        name: of its kind.
        size: all numbers are less than this.
    """

    name: str
    size: int

    def encode(self, text: str) -> list[int]:
        """Return the numbers of a text, each from 1 to `size` - 1; at least one."""

    def dump(self) -> bytes:
        """Return what `restore` makes it from again."""


def normalise(text: str) -> str:
    """Return a text in NFC without zero-width joiners."""
    return unicodedata.normalize("NFC", text.translate(_JOINERS))


class Words:
    """The paper's: whole words in lower case, by a vocabulary of those that occur at least twice in training."""

    name = "word"

    def __init__(self, vocabulary: Sequence[str]) -> None:
        self.vocabulary = tuple(vocabulary)
        self.size = len(self.vocabulary) + SPECIAL
        self._numbers = {word: number for number, word in enumerate(self.vocabulary, start=SPECIAL)}

    @classmethod
    def train(cls, texts: Iterable[str], least: int = 2) -> "Words":
        """Return a tokenizer with every word that occurs at least so often, sorted."""
        counts = Counter(word for text in texts for word in words(normalise(text)))
        return cls(sorted(word for word, count in counts.items() if count >= least))

    def encode(self, text: str) -> list[int]:
        """Return one number for each word and each punctuation mark."""
        return [self._numbers.get(word, UNKNOWN) for word in words(normalise(text))] or [UNKNOWN]

    def dump(self) -> bytes:
        """Return the vocabulary, one word a line."""
        return "\n".join(self.vocabulary).encode()

    @classmethod
    def restore(cls, dumped: bytes) -> "Words":
        """Return the tokenizer of a vocabulary."""
        return cls(dumped.decode().split("\n"))


class SentencePieces:
    """One unigram model of SentencePiece for all languages.

    Args:
        model: the model's file content.
    """

    name = "sentencepiece"

    def __init__(self, model: bytes) -> None:
        import sentencepiece

        self._model = model
        self._processor = sentencepiece.SentencePieceProcessor(model_proto=model)
        self.size = self._processor.get_piece_size()

    @classmethod
    def train(cls, texts: Iterable[str], pieces: int = PIECES) -> "SentencePieces":
        """Return a tokenizer trained on texts of all languages, with at most so many pieces."""
        import sentencepiece

        with tempfile.TemporaryDirectory() as folder:
            prefix = Path(folder) / "model"
            sentencepiece.SentencePieceTrainer.train(
                sentence_iterator=iter([normalise(text).casefold() for text in texts]),
                model_prefix=str(prefix),
                vocab_size=pieces,
                hard_vocab_limit=False,  # Few words, many texts: fewer pieces may be all that there are.
                model_type="unigram",
                character_coverage=1.0,
                normalization_rule_name="identity",
                pad_id=PAD,
                unk_id=UNKNOWN,
                bos_id=-1,
                eos_id=-1,
                num_threads=1,
                minloglevel=2,
            )
            return cls(prefix.with_suffix(".model").read_bytes())

    def encode(self, text: str) -> list[int]:
        """Return one number for each piece."""
        numbers: list[int] = self._processor.encode(normalise(text).casefold())
        return numbers or [UNKNOWN]

    def dump(self) -> bytes:
        """Return the content of the model's file."""
        return self._model

    @classmethod
    def restore(cls, dumped: bytes) -> "SentencePieces":
        """Return the tokenizer of a model's file."""
        return cls(dumped)


class XlmrPieces:
    """The vocabulary of XLM-R, limited to the pieces that occur in training.

    Args:
        source: a folder with a tokenizer of transformers.
        kept: the pieces' own numbers that have an embedding, in the order of the tokenizer's.
    """

    name = "xlmr"

    def __init__(self, source: str, kept: Sequence[int]) -> None:
        self._source, self.kept = source, tuple(kept)
        self._pieces = _xlmr(source)
        self._numbers = {piece: number for number, piece in enumerate(self.kept, start=SPECIAL)}
        self.size = len(self.kept) + SPECIAL

    @classmethod
    def train(cls, texts: Iterable[str], source: str) -> "XlmrPieces":
        """Return a tokenizer that knows the pieces of some texts."""
        pieces = _xlmr(source)
        return cls(source, sorted({piece for text in texts for piece in pieces.encode(normalise(text))}))

    def encode(self, text: str) -> list[int]:
        """Return one number for each piece."""
        return [self._numbers.get(piece, UNKNOWN) for piece in self._pieces.encode(normalise(text))] or [UNKNOWN]

    def dump(self) -> bytes:
        """Return source and pieces as JSON; the vocabulary itself stays where it is."""
        return json.dumps({"source": self._source, "kept": self.kept}).encode()

    @classmethod
    def restore(cls, dumped: bytes) -> "XlmrPieces":
        """Return the tokenizer of a source and pieces."""
        return cls(**json.loads(dumped))


RESTORERS: dict[str, Callable[[bytes], Tokenizer]] = {
    "word": Words.restore,
    "sentencepiece": SentencePieces.restore,
    "xlmr": XlmrPieces.restore,
}


def train_tokenizer(name: str, texts: Sequence[str], source: str = "") -> Tokenizer:
    """Return a tokenizer by name, made for texts.

    Args:
        name: one of RESTORERS.
        texts: of training, in all languages.
        source: of "xlmr", see `XlmrPieces`.

    Raises:
        ValueError: if there is none of that name, or "xlmr" has no source.
    """
    if name == "xlmr" and not source:
        raise ValueError("the tokenizer xlmr needs a folder that holds it: xlmr=FOLDER")
    if name == "word":
        return Words.train(texts)
    if name == "sentencepiece":
        return SentencePieces.train(texts)
    if name == "xlmr":
        return XlmrPieces.train(texts, source)
    raise _unknown(name)


def restore_tokenizer(name: str, dumped: bytes) -> Tokenizer:
    """Return the tokenizer that was dumped.

    Raises:
        ValueError: if there is none of that name.
    """
    if name not in RESTORERS:
        raise _unknown(name)
    return RESTORERS[name](dumped)


def _unknown(name: str) -> ValueError:
    return ValueError(f"there is no tokenizer {name!r}; there are {', '.join(RESTORERS)}")


def _xlmr(source: str) -> "_Plain":
    import transformers

    loaded: Any = transformers.AutoTokenizer.from_pretrained(source, local_files_only=True)
    return _Plain(loaded)


class _Plain:
    """A tokenizer of transformers, without special pieces."""

    def __init__(self, loaded: Any) -> None:
        self._loaded = loaded

    def encode(self, text: str) -> list[int]:
        return list(self._loaded.encode(text, add_special_tokens=False))
