"""Registration with Gymnasium, under the project's namespace and without it.

Gymnasium looks for no plugins since its release 1.0: something has to import this package first.
"""

import gymnasium

NAMESPACE = "arramon"
PACKAGE = "arramon_client.environments"

ENTRY_POINTS = {
    "ArraMon-v0": (f"{PACKAGE}.single:ArraMonEnv", f"{PACKAGE}.vector:make_vector"),
    "ArraMonRoom-v0": (f"{PACKAGE}.single:make_room", f"{PACKAGE}.vector:make_room_vector"),
}
"""Names of the environments, with what makes a single one and a vector of them."""


def register() -> None:
    """Register the environments; a second call does nothing."""
    for name, (single, vector) in ENTRY_POINTS.items():
        for id_ in (f"{NAMESPACE}/{name}", name):
            if id_ not in gymnasium.registry:
                gymnasium.register(id=id_, entry_point=single, vector_entry_point=vector)
