"""The languages of the instructions: data folders, and the code that uses them. Independent of server and agents."""

from lang.language import Language, UnknownLanguage, available, identify, load
from lang.reading.mentions import Mention
from lang.reading.reader import CannotRead

__all__ = ["CannotRead", "Language", "Mention", "UnknownLanguage", "available", "identify", "load"]
