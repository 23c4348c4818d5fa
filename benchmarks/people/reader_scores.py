"""The scores of machine readers' finished runs, by the server's own reports, beside those of the paper's people."""

import sys

from arramon.v1 import evaluation_pb2
from arramon_client.errors import ArramonClientError
from arramon_client.runs.listing import listed_runs
from arramon_client.transport.connection import Server, call, connect
from arramon_server.board.reference import read_references
from benchmarks.common import text_table
from benchmarks.people.reader_folder import PREFIX

METRICS = ("nDTW", "CTC-3", "rPOD@CTC-3", "PTC@CTC-3")
"""Columns: the paper's own, of which placement counts where CTC-3 is 1."""

PAPER_PEOPLE = (("H/W", "val_unseen"), ("H/W", "test_unseen"), ("H/E", "test_unseen"))
"""The paper's workers and its expert, who played only one split."""

FOOTNOTE = (
    "Machine readers are programs that play through the play page, by frames and texts alone; they are no people. The "
    "paper's people played other episodes, in another simulator; its workers' CTC is 1 by selection. Intervals: 95%, "
    "over episodes."
)


def print_scores(address: str) -> None:
    """Print the table of a server's finished runs; its errors end the program without a traceback."""
    try:
        print(score_table(address))
    except ArramonClientError as error:
        sys.exit(str(error))


def score_table(address: str) -> str:
    """Return the table of a server's finished runs, latest first.

    Args:
        address: the server's gRPC address.

    Raises:
        ArramonClientError: if the server cannot be reached, or refuses.
    """
    with connect(address) as server:
        rows = [
            _run_row(server, run)
            for run in listed_runs(server)
            if run.participant.startswith(PREFIX) and run.state == evaluation_pb2.RUN_STATE_COMPLETE
        ]
    for result in read_references():
        if (result.short, result.split) in PAPER_PEOPLE:
            total = result.rows["total"]
            values = [f"{total[metric]:.3f}" for metric in METRICS]
            rows.append([f"paper: {result.name}", result.split, result.language, "", "", *values])
    header = ["", "split", "language", "episodes", "aids", *METRICS]
    return f"{text_table(header, rows)}\n{FOOTNOTE}"


def _run_row(server: Server, run: evaluation_pb2.Run) -> list[str]:
    request = evaluation_pb2.GetReportRequest(run_id=run.run_id)
    report = call(server.stub.GetReport, request, server.address)
    (total,) = (row for row in report.rows if row.name == "total")
    scores = {score.metric: score for score in total.scores}
    aids = [argument.name for argument in run.agent_arguments if argument.value == "on"]
    values = [f"{scores[each].mean:.3f} ({scores[each].low:.3f}-{scores[each].high:.3f})" for each in METRICS]
    return [run.participant, run.split, run.language, str(run.episodes), " ".join(aids) or "none", *values]
