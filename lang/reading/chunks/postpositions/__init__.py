"""Parsers of chunks for languages with postpositions, such as Hindi."""

from arramon_lang.reading.chunks.postpositions.placement_parser import PlacementParser
from arramon_lang.reading.chunks.postpositions.route_parser import PostpositionRouteParser

__all__ = ["PlacementParser", "PostpositionRouteParser"]
