"""Training of the shipped SentencePiece model: one unigram model for all languages, on a split's instructions."""

from pathlib import Path

from arramon_agents.reading.recipe import SentencePieceRecipe
from arramon_agents.reading.tokenizers import SHIPPED, SentencePieces
from arramon_agents.simulated.meanings import read_samples
from arramon_agents.training.place import Place, Tell


def train(recipe: SentencePieceRecipe, place: Place, tell: Tell) -> Path:
    """Train the model, and return the path of its file.

    Raises:
        NotFound: if the data folder does not have the split.
    """
    place.output.mkdir(parents=True, exist_ok=True)
    path = place.output / SHIPPED.name
    texts = [sample.text for sample in read_samples(place.data, recipe.split)]
    tell(f"sentencepiece: {len(texts)} texts")
    path.write_bytes(SentencePieces.train(texts, recipe.pieces).dump())
    return path
