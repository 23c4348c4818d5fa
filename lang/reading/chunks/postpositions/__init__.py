"""Readers of chunks in languages whose words that relate things stand behind them, such as Hindi."""

from arramon_lang.reading.chunks.postpositions.placement_parser import PlacementParser
from arramon_lang.reading.chunks.postpositions.route_parser import PostpositionRouteParser

__all__ = ["PlacementParser", "PostpositionRouteParser"]
