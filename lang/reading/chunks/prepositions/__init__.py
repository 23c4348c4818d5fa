"""Readers of chunks in languages whose words that relate things stand before them, such as English."""

from arramon_lang.reading.chunks.prepositions.route_parser import PrepositionRouteParser

__all__ = ["PrepositionRouteParser"]
