"""The screening test before the first verification: its right answers. The pages' texts have the words."""

from collections.abc import Mapping

RIGHT_VERIFY: Mapping[str, str] = {"q1": "b", "q2": "c", "q3": "a", "q4": "b"}
"""Right choice of each question (`collect_screening_verify`)."""
