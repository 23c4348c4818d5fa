"""Training recipes of the learned reader: training on generated texts, and fine-tuning on people's texts."""

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class ReaderRecipe:
    """All settings of a training on generated texts in every language.

    Attributes:
        split: split whose instructions are the source of meanings, from which new texts are written.
        texts: number of new texts; four in five are written once more in a form that people type.
        init: weights to begin with: a file, or a folder, such as `agents/reading` in a clone for the shipped ones;
            empty for random ones.
        passes: number of epochs.
        batch: number of texts in a batch.
        learning_rate: peak learning rate.
        seed: seed of texts, order and initial weights.
    """

    split: str = "train"
    texts: int = 40_000
    init: str = ""
    passes: int = 5
    batch: int = 96
    learning_rate: float = 0.004
    seed: int = 0


@dataclass(frozen=True)
class FineTuningRecipe:
    """All settings of fine-tuning on people's texts.

    Attributes:
        languages: language of people's texts (exactly one).
        split: imported split (`arramon-server import-release`). Every second episode in playing order, from the second
            on, is used for training; the others are left for testing.
        init: weights to fine-tune; empty for the shipped ones.
        passes: number of epochs.
        batch: number of texts in a batch.
        learning_rate: peak learning rate.
        seed: seed of new texts and of the order.
    """

    languages: tuple[str, ...] = ("en",)
    split: str = "val_seen"
    init: str = ""
    passes: int = 4
    batch: int = 48
    learning_rate: float = 0.001
    seed: int = 0

    def __post_init__(self) -> None:
        if len(self.languages) != 1:
            raise ValueError(f"languages {','.join(self.languages)}: expected one language of people's texts")


RECIPES = {"reader": ReaderRecipe(), "reader_tuning": FineTuningRecipe()}


def smoke(recipe: ReaderRecipe | FineTuningRecipe) -> ReaderRecipe | FineTuningRecipe:
    """Return a recipe for smoke tests, which takes seconds and learns next to nothing."""
    recipe = replace(recipe, passes=1)
    return replace(recipe, texts=60) if isinstance(recipe, ReaderRecipe) else recipe
