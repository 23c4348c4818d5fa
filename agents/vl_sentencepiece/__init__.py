"""`agents.vl` with pieces of words: one model of SentencePiece for all languages. It needs the extra `torch`."""

from arramon_agents.requirements import PLAYING
from arramon_agents.vl import make_factory

__all__ = ["make_agent"]

make_agent = make_factory("vl_sentencepiece", (*PLAYING, "sentencepiece"))
