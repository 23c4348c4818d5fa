"""`agents.vl` with a SentencePiece tokenizer for all languages (extra `torch`)."""

from arramon_agents.requirements import PLAYING
from arramon_agents.vl import make_factory

__all__ = ["make_agent"]

make_agent = make_factory("vl_sentencepiece", (*PLAYING, "sentencepiece"))
