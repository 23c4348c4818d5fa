"""Constants of the world: its objects, how the agent moves and sees, and the assembly room (paper, section 3.1).

Server, data set, languages and agents import them from here. Lengths are in units of the original simulator, in which a
step forward is 1; headings are in degrees clockwise from +z, seen from above.
"""

import math
from enum import IntEnum

NAVIGATION, ASSEMBLY = "navigation", "assembly"

PHASES = (NAVIGATION, ASSEMBLY)
"""The phases of each turn, in order."""

TURNS = 2
"""Turns of an episode."""

STEPS_PER_PHASE = 150
"""Step limit of a phase in the original simulator."""

# Motion


class Action(IntEnum):
    """The actions of one step, numbered as in the official release."""

    FORWARD = 0
    LEFT = 1
    RIGHT = 2
    INTERACT = 3


STEP = 1.0
"""Distance of one FORWARD in the street; in the room FORWARD moves by one cell."""

TURN = 30.0
"""Angle of one LEFT or RIGHT, in degrees."""

TURN_DEGREES = round(TURN)
"""TURN as an int, for headings in whole degrees."""

HEADINGS = 12
"""Number of possible headings of the agent, TURN apart."""

AGENT_RADIUS = 0.25
"""Radius of the agent's body, a disc."""

REACH_SIDE, REACH_AHEAD = 0.5, 3.0
"""Extent of the pick-up box to each side and ahead."""

REACH_MARGIN = 0.05
"""Tolerance for an object's own extent: its centre may be this far outside the box. The ground-truth paths of the
official release require 0.035."""

# Camera

EYE_HEIGHT = 0.525
"""Height of the camera above the ground, and the y coordinate in every path."""

FIELD_OF_VIEW = 60.0
"""Vertical and horizontal field of view, in degrees; frames are square."""

DEPTH_UNIT = 0.001
"""Resolution of 16-bit depth images: the length that corresponds to the value 1."""

# Sensors

IMAGE_SENSORS = ("rgb", "depth", "segmentation")
"""Sensors whose data is an image."""

SENSORS = (*IMAGE_SENSORS, "pose", "oracle")
"""All sensors that a run can request, in the order in which they are listed."""

DEFAULT_SENSORS = ("rgb", "depth")
"""Sensors of a run that requests none by name: those of the paper's agents, the only ones of hidden splits."""

PREVIEW_LANGUAGES = ("te",)
"""Codes of the project's languages that are published for trial: no native speaker has reviewed them."""

# Notes

NOTE_BYTES = 2048
"""Maximum length of the note beside an action, in bytes of UTF-8; a host may allow fewer."""

# Objects

COLLECTIBLES = ("ball", "hourglass", "mug", "tv", "book", "bowl", "bucket")
"""Kinds of objects that can be picked up (the paper's figures 2 and 11)."""

COLLECTIBLE_COLOURS = ("green", "red", "blue", "white", "yellow", "brown", "purple")
COLLECTIBLE_PATTERNS = ("dotted", "striped")

FURNITURE = (
    "cone", "phone_booth", "bench", "lamp_post", "traffic_light", "dumpster", "barrier", "barrel", "tyre_stack",
    "hydrant", "mailbox", "bin", "bags", "tree", "stop_sign", "speed_sign", "banner", "car", "kiosk", "planter",
    "awning", "shop_sign", "zebra_crossing",
)  # fmt: skip
"""Kinds of street furniture."""

BANNER_COLOURS = ("red", "blue", "green", "yellow", "white", "black")
"""Background colours of banners."""

BANNER_SHAPES = ("star", "diamond", "triangle", "circle", "hexagon", "dot")
SHOPS = ("hotel", "cafe", "bank", "bakery", "pharmacy", "cinema")
"""Shops that a shop sign can name."""

FACADES = ("brick", "brown", "concrete", "glass", "white", "arched", "red", "grey", "yellow", "green", "blue")
"""Facades of buildings."""

# The assembly room

COLUMNS, ROWS = 5, 4

CELL_SIZE = 1.5
"""Side length of a cell of the room's floor."""

ROOM_START = (2, 0)
"""Column and row of the checkered tile on which every assembly phase begins, facing +row."""

WALLS = ("wood", "brick", "spotted", "striped")
"""Looks of the room's walls."""


def bearing(start: tuple[float, float], end: tuple[float, float]) -> float:
    """Return the heading from one place (x, z) to another, in degrees in [0, 360)."""
    return math.degrees(math.atan2(end[0] - start[0], end[1] - start[1])) % 360.0


def turn_between(before: float, after: float) -> float:
    """Return the smallest turn from one heading to another, in degrees in [-180, 180), positive clockwise."""
    return (after - before + 180.0) % 360.0 - 180.0
