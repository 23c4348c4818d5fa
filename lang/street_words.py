"""Numbers behind route words: distances, angles, usual colours; shared by planners and followers.

The paper gives no numbers. With these, the follower does best on the release's human instructions; the planner uses
them to predict where its instructions lead.
"""

DEGREES = {"slightly left": -30.0, "slightly right": 30.0, "left": -90.0, "right": 90.0, "around": 180.0}
"""Angle of each of `meaning.TURNS`, clockwise. A slight turn is one turn action of the agent."""

USUAL_COLOURS = {
    "bags": ("black",), "bench": ("brown",), "bin": ("green",), "hydrant": ("red",), "lamp_post": ("green",),
    "mailbox": ("blue",), "phone_booth": ("blue",), "speed_sign": ("white",), "stop_sign": ("red",),
    "traffic_light": ("black",), "tree": ("green",), "tyre_stack": ("black",),
}  # fmt: skip
"""Colours that people use for street furniture that exists in a single colour, which its label omits."""


def is_of_colour(stated: str, kind: str, colour: str) -> bool:
    """Return whether a stated colour matches a thing; "" is no stated colour, or a label without a colour."""
    return stated in ("", colour) or (not colour and stated in USUAL_COLOURS.get(kind, ()))


TURN_OFFSETS = {"at": 0.0, "before": -1.5, "after": 1.5}
"""Offset of a turn from a thing, for each of `meaning.TURN_POSITIONS`, in units along the walk."""

PAST_DISTANCE = 0.8
"""Distance beyond a thing at which a walk past it ends, in units along the walk."""

REACHED_WITHIN = {"to": 1.6, "towards": 3.0}
"""Distance from a thing at which a walk to or towards it ends, in units."""

PASSED_WITHIN = 2.0
"""Maximum lateral distance of a thing that a walk passes, in units."""

COUNTED_WITHIN = 5.0
"""Maximum lateral distance of things counted along the walk ("the second bench"), in units."""

GROUP_RADIUS = 6.0
"""Maximum distance of the members of a group ("the cones") from the nearest one, in units."""

CROSSED_DISTANCE = 4.0
"""Distance beyond a side street's opening at which a walk past or across it ends, in units."""

SAME_OPENING = 4.0
"""Maximum distance along the walk between openings on both sides of one intersection, in units."""

OFF_AXIS_WEIGHT = 1.5
"""Weight of the angle off the walking direction when the nearest matching thing is chosen, per squared radian."""

OPENING_RANGE = 7.0
"""Lateral range of the search for side streets, in units."""

OPENING_DEPTH = 2.5
"""Minimum lateral depth of a side street beyond the wall before it, in units."""

OPENING_INSET = 1.2
"""Distance beyond the end of that wall at which to turn into the side street, in units."""
