"""Readers of chunks in languages whose words that relate things stand before them, such as English."""

from arramon_lang.reading.chunks.prepositions.routes import RouteReader

__all__ = ["RouteReader"]
