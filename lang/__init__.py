"""The languages of the instructions: a folder of data each, and what reads them. Knows nothing of server or agents."""

from lang.language import Language, UnknownLanguage, available, identify, load
from lang.mentions import Mention
from lang.reading import CannotRead

__all__ = ["CannotRead", "Language", "Mention", "UnknownLanguage", "available", "identify", "load"]
