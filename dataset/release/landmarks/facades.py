"""Facades on which texts agree, such as "the blue building" along many paths."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

import arramon_client.world as world
from arramon_dataset.release.landmarks.alignment import align
from arramon_dataset.release.landmarks.kernels import kernel_frames, likelihood
from arramon_dataset.release.landmarks.mentions import FACADES
from arramon_dataset.release.landmarks.mixture import MentionsOfKind, peaks_of
from arramon_dataset.release.landmarks.recovery import CERTAIN, SIGNIFICANT, LandmarkMap, TurnText
from arramon_dataset.release.landmarks.turn_paths import Indices, Numbers
from arramon_server.episodes.provenance import RecoveredLook
from arramon_server.sim.section import Building

ALONG = 1.0
"""Spacing of the points of a facade at which mentions are evaluated, in units."""


def paint_facades(
    buildings: Sequence[Building], texts: Sequence[TurnText]
) -> tuple[tuple[Building, ...], tuple[RecoveredLook, ...]]:
    """Return the buildings with the facades on which texts agree, and the indices of these with their votes.

    Args:
        buildings: of a section.
        texts: all texts of the section.
    """
    points, owners = _outlines(buildings)
    rows, weights, looks = [], [], []
    for each in texts:
        if not any(event.kind == FACADES and event.look in world.FACADES for event in each.events):
            continue
        aligned = align(each.events, each.path, LandmarkMap().fit)
        for event, posterior in zip(each.events, aligned.posterior, strict=True):
            if event.kind != FACADES or event.look not in world.FACADES:
                continue
            chosen = np.flatnonzero(posterior >= SIGNIFICANT)
            origins, directions = kernel_frames(event, each.path)
            values = posterior[chosen] @ likelihood(event, origins[chosen], directions[chosen], points)
            rows.append(np.maximum.reduceat(values, owners))
            weights.append(event.weight)
            looks.append(event.look)
    if not rows:
        return tuple(buildings), ()
    centres = np.array([(building.x, building.z) for building in buildings])
    painted = list(buildings)
    recovered: list[RecoveredLook] = []
    mentions = MentionsOfKind(centres, np.array(rows), np.array(weights), looks, [""] * len(looks))
    for peak in peaks_of(mentions, CERTAIN):
        index = int(np.hypot(*(centres - (peak.x, peak.z)).T).argmin())
        if all(each.index != index for each in recovered):
            painted[index] = replace(painted[index], facade=peak.colours[0][0])
            recovered.append(RecoveredLook(index, round(peak.votes, 1)))
    return tuple(painted), tuple(recovered)


def _outlines(buildings: Sequence[Building]) -> tuple[Numbers, Indices]:
    """Return points on the buildings' walls, (n, 2) of (x, z), and the index of each building's first one."""
    points, firsts, count = [], [], 0
    for building in buildings:
        x = np.arange(-building.half_width, building.half_width + ALONG, ALONG).clip(max=building.half_width)
        z = np.arange(-building.half_length, building.half_length + ALONG, ALONG).clip(max=building.half_length)
        local = np.concatenate(
            [np.stack([x, np.full_like(x, side * building.half_length)], axis=1) for side in (-1, 1)]
            + [np.stack([np.full_like(z, side * building.half_width), z], axis=1) for side in (-1, 1)]
        )
        sin, cos = np.sin(np.radians(building.heading)), np.cos(np.radians(building.heading))
        turned = np.stack([local[:, 0] * cos + local[:, 1] * sin, local[:, 1] * cos - local[:, 0] * sin], axis=1)
        points.append(turned + np.array([building.x, building.z]))
        firsts.append(count)
        count += len(local)
    return np.concatenate(points), np.array(firsts, dtype=np.intp)
