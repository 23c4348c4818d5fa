"""Limits by which planner, gate and facts judge a path, side by side, with the reasons why they differ.

PLANNED limits are those of the planner (`instructions/navigation`), which states only what holds within them. ACCEPTED
limits are those of the gate (`instructions/gate`), which rejects what people would not accept; they are wider than the
planner's, so that the gate seldom rejects a plan at a limit. FACTS limits are those of the facts for writers and the
alignment model, which share nothing with the grammar; changing them requires training the shipped model again.

Angles are in degrees, distances in units. How paths are measured is the same for all: see `paths` beside this file.
"""

# Turns

PLANNED_SLIGHT, PLANNED_AROUND = 45.0, 145.0
"""Largest turn called slight, and smallest called "around": inside the gate's ranges for both words."""

ACCEPTED_TURNS = {30.0: (10.0, 48.0), 90.0: (44.0, 140.0), 180.0: (135.0, 180.0)}
"""By the nominal angle of a word for a turn: smallest and largest bend. The agent turns by multiples of 30: one is a
slight turn, two to four are one to a side, five and six are one around. Ranges overlap where people differ."""

ACCEPTED_WIDE_SLIGHT = (12.0, 50.0)
"""Smallest and largest wide bend around a slight turn: wider than for the turn itself, as it includes nearby bends."""

ACCEPTED_UNMENTIONED = 37.0
"""Largest bend that an instruction need not mention: one turn of 30, and what the zigzag of a path adds."""

FACTS_STRAIGHT, FACTS_SLIGHT, FACTS_AROUND = 15.0, 52.0, 140.0
"""Smallest turn reported at all, smallest that is not slight, and smallest reported as "around". They apply to turns
between legs, which do not zigzag like the path itself."""

# Straight ahead

PLANNED_STRAIGHT, ACCEPTED_STRAIGHT = 15.0, 18.0
"""Largest angle between the path and a thing described as straight ahead."""

PLANNED_IN_VIEW, ACCEPTED_FACED = 40.0, 40.0
"""Largest angle between the course and a landmark to walk to or to face. The gate measures it from the path."""

# Distances from the path

PLANNED_DEVIATION = 1.8
"""Largest distance of a predicted step from the path, wider than a leg's: predictions do not zigzag."""

FACTS_DEVIATION, FACTS_SHORTEST_LEG = 1.2, 1.6
"""Largest distance of the path from the reported legs, and length below which a leg is reported with the one before."""

PLANNED_AT, ACCEPTED_TURN_AT, ACCEPTED_AT = 3.0, 4.0, 4.5
"""Largest distance of the path from a thing that marks a turn, for the planner and for the gate, and from a thing to
walk to, whose end is less exact than a turn."""

ACCEPTED_BY, FACTS_BY = 7.0, 5.5
"""Largest distance of the path from a thing that it passes; facts list fewer things than people may mention."""

# Sides

PLANNED_ASIDE, ACCEPTED_ASIDE, ACCEPTED_ASIDE_ZEBRA, FACTS_ASIDE = 1.3, 0.9, 3.0, 1.0
"""Smallest lateral distance of a thing on the left or right. A zebra crossing is wide; the planner never states its
side. Facts report nearer things as on the path itself."""

ACCEPTED_BESIDE = (70.0, 125.0)
"""Range of the angle between the path and a thing that the walker has beside: the thing may be a little ahead."""

# The target and its landmark

PLANNED_NEAR, ACCEPTED_NEAR, FACTS_NEAR = 3.0, 4.0, 4.5
"""Largest distance of a target from the landmark that locates it; for facts, from what is reported around it."""

PLANNED_TWIN_GAP, ACCEPTED_TWIN_GAP = 8.0, 6.0
"""Distance from an object that looks like the target within which nothing may fit the name of that landmark."""

PLANNED_FAR, ACCEPTED_FAR = 12.0, 10.0
"""Least distance of what is "in the distance" from where the walk to it begins."""

PLANNED_RELATION_ANGLE, ACCEPTED_RELATION_ANGLE = 65.0, 75.0
"""Largest angle between the stated relation of target and landmark and the true direction."""

PLANNED_LAST_VIEWS, ACCEPTED_LAST_VIEWS = 6, 5
"""From how many last poses, or places of the path, the relation must hold. Turns add poses, not places."""

PLANNED_ZEBRA_MARGIN, ACCEPTED_ZEBRA_MARGIN = 0.4, 0.3
"""Margin around a zebra crossing within which an object is on it rather than beside it: its half extent, for the gate
just enough that part of it is on the stripes."""
