"""What all subcommands share: a reader of their output that has ended is no error to be explained."""

import subprocess
import sys

PRINT_MUCH = """
import argparse, sys
from arramon_client.commands.base import run
sys.exit(run(argparse.ArgumentParser(), [], lambda options: print("note\\n" * 100_000)))
"""


def test_output_whose_reader_has_ended() -> None:
    with subprocess.Popen(
        [sys.executable, "-c", PRINT_MUCH], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        assert process.stdout.readline() == b"note\n"
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 1
