"""Training of the shipped SentencePiece model, one for all languages, on the instructions of a split."""

from pathlib import Path

from arramon_agents.reading.recipe import SentencePieceRecipe
from arramon_agents.reading.tokenizers import SHIPPED, SentencePieceTokenizer
from arramon_agents.simulated.meanings import read_samples
from arramon_agents.training.workspace import Report, Workspace


def train(recipe: SentencePieceRecipe, workspace: Workspace, report: Report) -> Path:
    """Train the model, and return the path of its file.

    Raises:
        UsageError: if the data folder does not have the split.
    """
    workspace.output.mkdir(parents=True, exist_ok=True)
    path = workspace.output / SHIPPED.name
    texts = [sample.text for sample in read_samples(workspace.data, recipe.split)]
    report(f"sentencepiece: {len(texts)} texts")
    path.write_bytes(SentencePieceTokenizer.train(texts, recipe.pieces).dump())
    return path
