"""What the words of the street mean in numbers: one semantics for who plans an instruction and who follows it.

The paper gives no numbers. These are the follower's, by which it walks what the release's people wrote; the planner
reckons with the same where its words lead one who is so understood.
"""

DEGREES = {"slightly left": -30.0, "slightly right": 30.0, "left": -90.0, "right": 90.0, "around": 180.0}
"""Of `meaning.TURNS`, clockwise. A slight turn is one of the agent's own."""

ALONG = {"at": 0.0, "before": -1.5, "after": 1.5}
"""Of `meaning.ATS`: where a turn is taken from the thing, in units along the walk."""

PAST = 0.8
"""How far beyond a thing a walk past it leads, in units along the walk."""

NEAR = {"to": 1.6, "towards": 3.0}
"""How near to a thing a walk leads, in units."""

BESIDE = 2.0
"""How far beside a thing a walk goes by it at most, in units."""

OFF_AXIS = 1.5
"""Of several things of a name the nearest is meant, and one off the course counts as farther away: by so much for each
squared radian."""

DEEP = 7.0
"""How far to the side the ground is looked at for a street that opens there, in units."""

DEEPER = 2.5
"""By how much an opening is deeper than the street beside the wall before it, in units."""

IN = 1.2
"""How far past that wall's end the turn into the opening is taken, in units."""
