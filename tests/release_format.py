"""Episodes in the official release's format, made up for tests."""

import math
from typing import Any

HEADING = 28.8

TEXTS = {
    "en": ("Go straight on to the dotted yellow ball.", "Put it on top of the striped blue mug."),
    "hi": ("बिंदीदार पीली गेंद तक सीधे चलें।", "उसे धारीदार नीले मग के ऊपर रखें।"),
}


def record(map_id: int, language: str = "en", steps: int = 12) -> dict[str, Any]:
    """Both turns lead `steps` units straight on, each to an object 1.5 units ahead."""
    step = (math.sin(math.radians(HEADING)), math.cos(math.radians(HEADING)))

    def point(number: float) -> list[float]:
        return [round(number * step[0], 6), 0.525, round(number * step[1], 6)]

    paths = [[point(first + i) for i in range(steps + 1)] for first in (0, steps)]
    navigation, assembly = TEXTS[language]
    return {
        "mapId": map_id,
        "code": "X",
        "instructions": {"navi_inst_gt": [navigation] * 2, "assem_inst_gt": [assembly] * 2},
        "gt_paths": {
            "navi_path_gt": paths,
            "assem_path_gt": [[[0.0, 0.0, 0.0], [0.0, 0.0, 1.5]], [[9.0, 0.0, 9.0], [9.0, 0.0, 10.5]]],
        },
        "gt_actionIDs": {
            "navi_actionIDs_gt": [[1, 2, *[0] * steps, 3], [*[0] * steps, 3]],
            "assem_actionIDs_gt": [[0, 3], [0, 3]],
        },
        "gt_objects": ["Dotted Yellow Ball", "Striped Red Tv"],
        "gt_objects_pos": {
            "navi_obj_pos_gt": [point(steps + 1.5), point(2 * steps + 1.5)],
            "assem_obj_pos_gt": [[2, 1, 2], [2, 2, 2]],
        },
    }
