"""Train the shipped SentencePiece model: `python -m arramon_agents.reading.train_sentencepiece --data DATA`.

One unigram model for all languages, on a split's instructions. It takes seconds.
"""

import argparse
from pathlib import Path

from arramon_agents.reading.tokenizers import PIECES, SHIPPED, SentencePieces
from arramon_agents.simulated.meanings import read_samples


def main() -> None:
    """Train, and write the model."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--data", type=Path, default=Path("arramon-data"), help="data folder (default: %(default)s)")
    parser.add_argument("--split", default="train", help="split whose instructions are taken (default: %(default)s)")
    parser.add_argument("--pieces", type=int, default=PIECES, help="at most so many (default: %(default)s)")
    parser.add_argument("--out", type=Path, default=SHIPPED, help="the file (default: the shipped one)")
    given = parser.parse_args()
    texts = [sample.text for sample in read_samples(given.data, given.split)]
    given.out.write_bytes(SentencePieces.train(texts, given.pieces).dump())


if __name__ == "__main__":
    main()
