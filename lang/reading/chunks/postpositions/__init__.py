"""Readers of chunks in languages whose words that relate things stand behind them, such as Hindi."""

from arramon_lang.reading.chunks.postpositions.rooms import RoomReader
from arramon_lang.reading.chunks.postpositions.routes import RouteReader

__all__ = ["RoomReader", "RouteReader"]
