"""Recovery of a section's landmarks from what people said about them along known paths.

`mentions` reads the texts, `walks` and `kernels` say where a mentioned thing may be, `alignment` finds the moment of each
mention, `mixture` the places on which many mentions agree, and `recovery` runs them in turns.
"""
