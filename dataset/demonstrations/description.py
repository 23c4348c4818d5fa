"""Descriptions of an export and its sensors, for its record, its card and its Croissant file."""

from collections.abc import Mapping
from typing import Any

from arramon_dataset.demonstrations.request import MINARI, ResolvedExport
from arramon_server.sim.labels import LABELS

UNITS = {
    "rgb": ("uint8", "red, green and blue, 0 to 255"),
    "depth": ("float32", "units along the viewing direction; 0 where there is nothing, at most 65.535"),
    "segmentation": ("uint16", "index in `labels` of demonstrations.json: kind, colour, look"),
    "pose": ("float64", "x and z in units, heading in degrees clockwise from +z; in the room column and row"),
}
"""Data type of each sensor's values, and their unit or meaning."""

ACTIONS = ("forward", "left", "right", "interact")
"""Names of the actions, by number."""


def shape_of(sensor: str, size: int) -> tuple[int, ...]:
    """Return the shape of one value of a sensor."""
    return {"rgb": (size, size, 3), "pose": (3,)}.get(sensor, (size, size))


def dtype_of(sensor: str, export: ResolvedExport) -> str:
    """Return the data type of a sensor's values; segmentations in Minari have the environment's type."""
    return "int16" if (sensor, export.request.format) == ("segmentation", MINARI) else UNITS[sensor][0]


def sensors_of(export: ResolvedExport) -> dict[str, dict[str, Any]]:
    """Return type, shape and unit of each exported sensor, as plain data."""
    return {
        sensor: {
            "dtype": dtype_of(sensor, export),
            "shape": list(shape_of(sensor, export.request.size)),
            "unit": UNITS[sensor][1],
        }
        for sensor in export.request.sensors
    }


def describe_export(export: ResolvedExport) -> str:
    """Return a one-sentence description of an export."""
    request = export.request
    what = "the ground truth" if request.run_id is None else f"the recorded run {request.run_id}"
    frames = f" with {', '.join(request.sensors)}" if request.sensors else ", without frames"
    size = f" at {request.size} x {request.size} pixels" if set(request.sensors) - {"pose"} else ""
    return (
        f"Demonstrations of ArraMon, an agent that follows instructions through a city and assembles what it finds: "
        f"{what} of the split {request.split} ({export.source}; data {export.data_hash[:12]}) in "
        f"{', '.join(request.languages)}{frames}{size}, {export.episodes} episodes with {export.steps} steps."
    )


def record_of(export: ResolvedExport, counts: Mapping[str, int]) -> dict[str, Any]:
    """Return the record of a complete export, as plain data.

    Args:
        export: the complete export.
        counts: number of episodes by language.
    """
    uses_labels = "segmentation" in export.request.sensors
    return {
        "complete": True,
        "description": describe_export(export),
        "settings": export.settings(),
        "actions": list(ACTIONS),
        "sensors": sensors_of(export),
        "labels": [[label.kind, label.colour, label.look] for label in LABELS] if uses_labels else [],
        "episodes_by_language": dict(counts),
    }
