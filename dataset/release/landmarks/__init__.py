"""Recovery of a section's landmarks from people's instructions along known paths.

`mentions` reads the texts; `turn_paths` and `kernels` give the likelihood of a mentioned thing at each place;
`alignment` finds the place of the walker at each mention, and `mixture` the places on which many mentions agree;
`recovery` alternates these two. `scenery` adds the recovered landmarks to a section, `text_colours` changes their
colours to those that an episode's own texts state, `own_furniture` adds the furniture that these texts name, and
`distracters` furniture that they do not name. `agreement` decides which mentions of a text are true in a world.
"""
