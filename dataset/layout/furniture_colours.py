"""Colours for random street furniture and banners; colours that people mention more often are likelier."""

from arramon_server.sim.assets import furniture

COLOURS = {
    **furniture.COLOURS,
    "cone": ("orange", "orange", "red", "blue"),
    "banner": ("red", "blue", "green", "yellow", "white", "black"),
}
"""Colours of each kind; likelier ones are repeated."""

SHAPE_COLOURS = {
    "red": ("white", "yellow", "black"), "blue": ("white", "yellow", "red"), "green": ("white", "yellow", "red"),
    "yellow": ("red", "blue", "black"), "white": ("red", "blue", "green"), "black": ("white", "yellow", "red"),
}  # fmt: skip
"""Colours of a banner's shape, by the banner's ground colour."""
