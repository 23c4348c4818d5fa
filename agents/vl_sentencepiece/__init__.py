"""`agents.vl` with a SentencePiece tokenizer for all languages (extra `torch`)."""

from arramon_agents.requirements import REQUIRED_AT_PLAY
from arramon_agents.vl import make_factory

__all__ = ["make_agent"]

make_agent = make_factory("vl_sentencepiece", (*REQUIRED_AT_PLAY, "sentencepiece"))
