"""Time that an agent takes for its answers, as the server sees it."""


class Thinking:
    """Time between the moment at which an observation is handed to the transport and the arrival of its answer.

    It contains what lies between: the network both ways, the client's decoding, and where an agent answers several
    episodes together, the time for all of them. Steps whose observation was sent before the stream broke are left out.

    Attributes:
        seconds: in all.
        steps: number of the steps that were measured.
    """

    def __init__(self) -> None:
        self.seconds, self.steps = 0.0, 0
        self._step = -1
        self._sent: float | None = None

    def skip(self, step: int) -> None:
        """Leave a step out: its observation may have been sent on another stream."""
        self._step, self._sent = step, None

    def send(self, step: int, at: float) -> None:
        """Note that the observation of a step is handed to the transport; a repeated one changes nothing."""
        if step != self._step:
            self._step, self._sent = step, at

    def answer(self, step: int, at: float) -> None:
        """Note the arrival of the answer to a step."""
        if step == self._step and self._sent is not None:
            self.seconds += max(0.0, at - self._sent)
            self.steps += 1
