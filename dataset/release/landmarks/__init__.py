"""Recovery of a section's landmarks from what people said about them along known paths.

`mentions` reads the texts, `walks` and `kernels` say where a mentioned thing may be, `alignment` finds the moment of
each mention, `mixture` the places on which many mentions agree, and `recovery` runs them in turns. `scenery` builds
what was recovered into a section, `own` gives each episode what its own texts name, and `strays` what nobody named.
`agreement` says which mentions of a text fit a world.
"""
