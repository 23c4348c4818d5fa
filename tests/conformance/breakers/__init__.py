"""For each check, a fault of the server that makes it fail, and the reason that the check must give."""

from typing import NamedTuple

from tests.conformance.breakers.images import IMAGES
from tests.conformance.breakers.information import INFORMATION, RUNS
from tests.conformance.breakers.notes import NOTES
from tests.conformance.breakers.refusals import ACCEPTED, NO_MESSAGE, REFUSALS, WRONG_STATUS
from tests.conformance.breakers.results import RESULTS
from tests.conformance.breakers.steps import STEPS
from tests.conformance.breakers.streams import LIMITS, STREAMS
from tests.conformance.forwarder import Fault, Metadata


class Breaker(NamedTuple):
    """A fault that makes a check fail with words that match a pattern."""

    check: str
    fault: Fault
    pattern: str


def breakers(token: str) -> list[Breaker]:
    """Return what breaks each check.

    Args:
        token: that the server takes.
    """

    def any_token(metadata: Metadata) -> Metadata:
        return (*(pair for pair in metadata if pair[0] != "authorization"), ("authorization", f"Bearer {token}"))

    return [
        *(Breaker(name, WRONG_STATUS, r"was refused with UNKNOWN \(.+\), expected [A-Z_]+$") for name in REFUSALS),
        *(Breaker(name, NO_MESSAGE, r"was refused with [A-Z_]+ and no message") for name in REFUSALS),
        *(
            Breaker(*each)
            for each in (*INFORMATION, *RUNS, *STEPS, *STREAMS, *LIMITS, *NOTES, *IMAGES, *ACCEPTED, *RESULTS)
        ),
        Breaker("notes.private", Fault(metadata=any_token), "ListNotes by a caller without a token was accepted"),
        Breaker("refusals.token", Fault(metadata=any_token), r"CreateRun by a token .* refused with NOT_FOUND"),
        Breaker("refusals.anonymous", Fault(metadata=any_token), r"CreateRun by a caller .* refused with NOT_FOUND"),
    ]
