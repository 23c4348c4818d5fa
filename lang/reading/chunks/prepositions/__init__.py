"""Parser of chunks for languages with prepositions, such as English."""

from arramon_lang.reading.chunks.prepositions.route_parser import PrepositionRouteParser

__all__ = ["PrepositionRouteParser"]
