"""Semantics of words for streets in numbers, shared by planners and followers.

The paper gives no numbers. These are those with which the follower best walks the release's human instructions; the
planner uses the same to predict where its words lead.
"""

DEGREES = {"slightly left": -30.0, "slightly right": 30.0, "left": -90.0, "right": 90.0, "around": 180.0}
"""Angle of each of `meaning.TURNS`, clockwise. A slight turn is one turn action of the agent."""

USUAL_COLOURS = {
    "bags": ("black",), "bench": ("brown",), "bin": ("green",), "hydrant": ("red",), "lamp_post": ("green",),
    "mailbox": ("blue",), "phone_booth": ("blue",), "speed_sign": ("white",), "stop_sign": ("red",),
    "traffic_light": ("black",), "tree": ("green",), "tyre_stack": ("black",),
}  # fmt: skip
"""Colours that people name of street furniture that comes in one colour, whose label names none."""


def is_of_colour(said: str, kind: str, colour: str) -> bool:
    """Return whether a colour that is said, "" if none is, fits a thing of a kind whose label names a colour, or ""."""
    return said in ("", colour) or (not colour and said in USUAL_COLOURS.get(kind, ()))


ALONG = {"at": 0.0, "before": -1.5, "after": 1.5}
"""Where a turn is made relative to a thing, by `meaning.ATS`, in units along the walk."""

PAST = 0.8
"""How far beyond a thing a walk past it ends, in units along the walk."""

NEAR = {"to": 1.6, "towards": 3.0}
"""Distance from a thing at which a walk to it ends, in units."""

BESIDE = 2.0
"""Maximum lateral distance at which a walk passes a thing, in units."""

COUNTED_ASIDE = 5.0
"""Maximum distance from the course of things that are counted along it ("the second bench"), in units."""

GROUP = 6.0
"""Maximum distance of things that are named together from the nearest of them ("the cones"), in units."""

ACROSS = 4.0
"""How far beyond the place where a street opens a walk past it, or across it, ends, in units."""

SAME_OPENING = 4.0
"""Openings on both sides that are nearer than this along the walk belong to one crossing, in units."""

OFF_AXIS = 1.5
"""A name refers to the nearest matching thing, where a thing off the course counts as farther away: by this factor for
each squared radian."""

DEEP = 7.0
"""How far to the side the ground is searched for streets that open there, in units."""

DEEPER = 2.5
"""Minimum extra depth of an opening compared with the street beside the wall before it, in units."""

IN = 1.2
"""Distance beyond that wall's end at which to turn into the opening, in units."""
