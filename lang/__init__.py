"""Writing and reading of instructions in each language, from data folders; independent of server and agents."""

from arramon_lang.language import Language, UnknownLanguage, available, identify, load, required
from arramon_lang.reading.mentions import Mention
from arramon_lang.reading.parser import CannotRead

__all__ = ["CannotRead", "Language", "Mention", "UnknownLanguage", "available", "identify", "load", "required"]
