"""Aids that a host gives to people who play: settings of a run, recorded among its agent's arguments."""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

from arramon_client.world import IMAGE_SENSORS
from arramon_server.configuration.config import Config
from arramon_server.runs.storage.records import Run

ON, OFF = "on", "off"

ALWAYS_RECORDED = ("landing_diagram", "frame_strip", "compass")
"""Aids that every run records. The others came later and are recorded where they are on, so that signatures of runs
without them stay as they were."""


@dataclass(frozen=True, slots=True)
class Aids:
    """Aids for people. The paper's people had the landing diagram (section "Interface"), its agents had none.

    Attributes:
        landing_diagram: a diagram of the room, with the cell in which the object would be placed.
        frame_strip: the last frames beside the current one.
        compass: the heading relative to the start of the phase.
        look_around: views in other headings, without steps.
        zoom: magnification of the frame.
        pictured_names: drawings of the things that instructions name, with their words.
        ahead: what a pick-up would take, and in the room the cell ahead and what is on it.
        scene_words: the visible things in words, from segmentation and depth.
    """

    landing_diagram: bool = False
    frame_strip: bool = False
    compass: bool = False
    look_around: bool = False
    zoom: bool = False
    pictured_names: bool = False
    ahead: bool = False
    scene_words: bool = False

    @classmethod
    def of_config(cls, config: Config) -> "Aids":
        """Return the aids that the host gives in new runs."""
        return cls(**{field.name: getattr(config, f"play_{field.name}") for field in fields(cls)})

    @classmethod
    def of_run(cls, run: Run) -> "Aids":
        """Return the aids of a run, which stay the same when the host changes its settings."""
        arguments = dict(run.agent_arguments)
        return cls(**{field.name: arguments.get(field.name) == ON for field in fields(cls)})

    @property
    def sensors(self) -> tuple[str, ...]:
        """Sensors of a run with these aids: those that an agent would need to know as much."""
        return IMAGE_SENSORS if self.scene_words else ("rgb",)

    def offered_with(self, sensors: Sequence[str]) -> "Aids":
        """Return the aids that need no more than these sensors, which a split offers."""
        return self if set(self.sensors) <= set(sensors) else replace(self, scene_words=False)

    def as_arguments(self) -> Sequence[tuple[str, str]]:
        """Return the aids as arguments of the agent."""
        return [
            (name, ON if is_on else OFF) for name, is_on in self.named().items() if is_on or name in ALWAYS_RECORDED
        ]

    def named(self) -> dict[str, bool]:
        """Return whether each aid is given, by name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}


NO_AIDS = Aids()
