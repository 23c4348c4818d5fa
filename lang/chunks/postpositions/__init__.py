"""Readers of chunks in languages whose words that relate things stand behind them, such as Hindi."""

from lang.chunks.postpositions.rooms import RoomReader
from lang.chunks.postpositions.routes import RouteReader

__all__ = ["RoomReader", "RouteReader"]
