"""A wrapper that Gymnasium does not have: poses relative to the start of the phase.

Use Gymnasium's own for the rest: `FilterObservation` (for example, to remove texts), `FlattenObservation`,
`TransformObservation`, `FrameStackObservation`. The option `image_size` sets the size of images, and
`instruction_tokens` has the instruction as numbers.
"""

import math
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

from arramon_client.environments.errors import BadArgument
from arramon_client.environments.spaces import Dict


class StartFrame(gymnasium.ObservationWrapper[Dict, np.int64, Dict]):
    """Makes the pose relative to the start of the phase: units to the right and ahead, degrees clockwise.

    Each phase starts at (0, 0, 0), so that an agent does not learn where in the city it is.

    Args:
        env: environment with the sensor "pose", and the keys "turn" and "phase" in its observation.

    Raises:
        BadArgument: if the sensor or a key is missing.
    """

    def __init__(self, env: gymnasium.Env[Dict, np.int64]) -> None:
        super().__init__(env)
        inner = env.observation_space
        if not isinstance(inner, spaces.Dict) or "pose" not in inner.spaces:
            raise BadArgument("StartFrame needs the sensor 'pose': add it to sensors=(...)")
        for key in ("turn", "phase"):
            if key not in inner.spaces:
                raise BadArgument(f"StartFrame needs the key {key!r} in the observation: add it to observe=(...)")
        pose = inner["pose"]
        assert isinstance(pose, spaces.Box)
        reach = float(2 * pose.high[0])
        low, high = np.array((-reach, -reach, 0.0)), np.array((reach, reach, 360.0))
        self.observation_space = spaces.Dict({**inner.spaces, "pose": spaces.Box(low, high, dtype=np.float64)})
        self._phase: tuple[int, int] | None = None
        self._start = (0.0, 0.0, 0.0)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Dict, dict[str, Any]]:
        """Begin an episode."""
        self._phase = None
        return super().reset(seed=seed, options=options)

    def observation(self, observation: Dict) -> Dict:
        """Return the observation with the relative pose."""
        x, z, heading = (float(each) for each in observation["pose"])
        phase = int(observation["turn"]), int(observation["phase"])
        if phase != self._phase:
            self._phase, self._start = phase, (x, z, heading)
        x0, z0, heading0 = self._start
        angle, dx, dz = math.radians(heading0), x - x0, z - z0
        right = dx * math.cos(angle) - dz * math.sin(angle)
        ahead = dx * math.sin(angle) + dz * math.cos(angle)
        return {**observation, "pose": np.array((right, ahead, (heading - heading0) % 360.0))}
