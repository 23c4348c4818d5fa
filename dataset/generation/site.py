"""A section with its geometry, physics, cameras and sampler, as generation needs them."""

from functools import cached_property

from arramon_dataset.generation.draft_sampler import DraftSampler
from arramon_dataset.instructions.visible_landmarks import with_names_as_labels
from arramon_dataset.layout.solids import Solids
from arramon_dataset.plans.graph import StreetGraph
from arramon_dataset.plans.graph_builder import street_graph
from arramon_dataset.plans.plan import Plan
from arramon_server.sim.cameras import Camera
from arramon_server.sim.own_furniture import NO_FURNITURE
from arramon_server.sim.physics import Physics
from arramon_server.sim.raster.camera import RasterCamera
from arramon_server.sim.rules import EpisodeLayout
from arramon_server.sim.scene import Scene
from arramon_server.sim.section import Section
from arramon_server.sim.section_world import EpisodeWorld, SectionWorld


class GenerationSite:
    """A section with everything that generation needs, each part built on first use. Not thread-safe.

    Attributes:
        section: the section itself.
        plan: the street plan that it was built from; None for a section reconstructed from paths.
    """

    def __init__(self, section: Section, plan: Plan | None = None) -> None:
        self.section, self.plan = section, plan
        self._loaded = SectionWorld(section)

    @cached_property
    def graph(self) -> StreetGraph | None:
        """The section's street graph; None without a plan."""
        return None if self.plan is None else street_graph(self.plan, self.section)

    @property
    def scene(self) -> Scene:
        """The section's scene."""
        return self._loaded.scene

    @cached_property
    def solids(self) -> Solids:
        """The section's solids."""
        return Solids.of(self.section)

    @property
    def physics(self) -> Physics:
        """The section's physics, the authoritative collision check."""
        return self._loaded.physics

    @property
    def camera(self) -> Camera:
        """The section's fast camera."""
        return self._loaded.camera

    def in_episode(self, layout: EpisodeLayout) -> EpisodeWorld:
        """Return the world of an episode that has the section's furniture."""
        return self._loaded.in_episode(NO_FURNITURE, layout)

    @cached_property
    def landmark_camera(self) -> Camera:
        """A camera whose labels are the names of bodies, for `visible_landmarks.find_landmarks`."""
        return RasterCamera(with_names_as_labels(self.scene))

    @cached_property
    def sampler(self) -> DraftSampler:
        """The sampler of drafts in this section."""
        return DraftSampler(self.section)
