"""The paper's statistics of its own data, for comparison."""

LENGTHS: dict[str, dict[str, tuple[float, int]]] = {
    "navigation": {"words": (47.99, 147), "path": (48.14, 156), "actions": (75.78, 224)},
    "assembly": {"words": (20.99, 90), "path": (3.32, 8), "actions": (13.68, 34)},
}
"""Mean and maximum of the sum over an episode's two turns (the paper's table of lengths). Path lengths are in steps."""

PROPERTIES: dict[str, dict[str, float]] = {
    "navigation": {
        "egocentric": 0.34,
        "allocentric": 0.86,
        "temporal": 0.64,
        "directional": 0.96,
        "sequencing": 0.66,
        "discrete_3d": 0.72,
    },
    "assembly": {
        "egocentric": 0.34,
        "allocentric": 0.98,
        "temporal": 0.02,
        "directional": 0.68,
        "sequencing": 0.58,
        "discrete_3d": 0.34,
    },
}
"""Share of 50 manually annotated episodes (appendix, table of linguistic properties)."""
