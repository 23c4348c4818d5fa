"""Response times of an agent, as measured by the server."""


class ResponseTimes:
    """Time between sending an observation to the transport and receiving its answer.

    It includes the network in both directions, the client's decoding and, if an agent answers several episodes in one
    batch, the time for all of them. Steps whose observation was sent before the stream broke are left out.

    Attributes:
        seconds: total response time.
        steps: number of the steps that were measured.
    """

    def __init__(self) -> None:
        self.seconds, self.steps = 0.0, 0
        self._step = -1
        self._sent: float | None = None

    def skip(self, step: int) -> None:
        """Exclude a step, as its observation may have been sent on another stream."""
        self._step, self._sent = step, None

    def send(self, step: int, at: float) -> None:
        """Note the time at which a step's observation was sent; a repeated call changes nothing."""
        if step != self._step:
            self._step, self._sent = step, at

    def answer(self, step: int, at: float) -> None:
        """Add the response time of a step."""
        if step == self._step and self._sent is not None:
            self.seconds += max(0.0, at - self._sent)
            self.steps += 1
