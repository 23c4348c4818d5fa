"""Aids that a host gives to people who play: settings of a run, recorded among its agent's arguments."""

from collections.abc import Sequence
from dataclasses import dataclass, fields

from arramon_server.configuration.config import Config
from arramon_server.runs.storage.records import Run

ON, OFF = "on", "off"


@dataclass(frozen=True, slots=True)
class Aids:
    """Aids for people. The paper's people had the landing diagram (section "Interface"), its agents had none.

    Attributes:
        landing_diagram: a diagram of the room, with the cell in which the object would be placed.
        frame_strip: the last frames beside the current one.
        compass: the heading relative to the start of the phase.
    """

    landing_diagram: bool = False
    frame_strip: bool = False
    compass: bool = False

    @classmethod
    def of_config(cls, config: Config) -> "Aids":
        """Return the aids that the host gives in new runs."""
        return cls(config.play_landing_diagram, config.play_frame_strip, config.play_compass)

    @classmethod
    def of_run(cls, run: Run) -> "Aids":
        """Return the aids of a run, which stay the same when the host changes its settings."""
        arguments = dict(run.agent_arguments)
        return cls(**{field.name: arguments.get(field.name) == ON for field in fields(cls)})

    def as_arguments(self) -> Sequence[tuple[str, str]]:
        """Return the aids as arguments of the agent."""
        return [(name, ON if is_on else OFF) for name, is_on in self.named().items()]

    def named(self) -> dict[str, bool]:
        """Return whether each aid is given, by name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}
