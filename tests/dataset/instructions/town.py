"""A small crossing for tests: four blocks, streets 6 units wide along both axes, some furniture and collectibles."""

from arramon_client.world import Action
from arramon_server.sim.catalogue import ObjectType
from arramon_server.sim.geometry import Point, Pose
from arramon_server.sim.rules import Collectible
from arramon_server.sim.section import Building, Prop, Section

F, L, R, P = Action.FORWARD, Action.LEFT, Action.RIGHT, Action.INTERACT


def crossing(*more: Prop) -> Section:
    """Blocks of 20 units in all four quadrants, 3 units from both axes; the street ends are closed."""
    blocks = [Building(x, z, 10.0, 10.0, 0.0, 5.0, "brick") for x in (-13.0, 13.0) for z in (-13.0, 13.0)]
    ends = [
        Building(x, z, 3.0, 3.0, 0.0, 5.0, "glass") for x, z in ((0.0, 26.0), (0.0, -26.0), (26.0, 0.0), (-26.0, 0.0))
    ]
    props = (Prop("phone_booth", 2.4, -3.4, 0.0), Prop("tree", -2.6, 2.6, 0.0), Prop("kiosk", 9.0, -2.5, 0.0), *more)
    return Section("test", 0.0, (-23.0, -23.0, 23.0, 23.0), tuple(blocks + ends), props)


def thing(name: str, x: float, z: float) -> Collectible:
    """A collectible by a name such as "striped red mug"."""
    return Collectible(ObjectType.parse(name), Point(x, 0.1, z))


START = Pose(0.0, -15.0, 0.0)
PATH = tuple((0.0, float(z)) for z in range(-15, 1)) + tuple((float(x), 0.0) for x in range(1, 13))
"""North along the street, right at the crossing, then east."""

ACTIONS = (F,) * 15 + (R,) * 3 + (F,) * 12 + (P,)
STREET = (
    thing("striped red mug", 13.5, 0.0),
    thing("dotted red mug", 0.0, 12.0),
    thing("striped blue ball", -9.0, 0.5),
)
"""The target first."""
