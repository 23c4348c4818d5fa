"""Training recipes of the learned reader: on generated texts, and fine-tuned on people's."""

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class ReaderRecipe:
    """All settings of a training on generated texts in every language.

    Attributes:
        split: whose instructions are read; new texts with other things are written from their plans.
        texts: number of texts written anew.
        passes: number of epochs.
        batch: number of texts in a batch.
        learning_rate: the highest.
        seed: of texts, their order and initial weights.
    """

    split: str = "train"
    texts: int = 40_000
    passes: int = 4
    batch: int = 48
    learning_rate: float = 0.003
    seed: int = 0


@dataclass(frozen=True)
class TuningRecipe:
    """All settings of fine-tuning on people's texts.

    Attributes:
        languages: of people's texts.
        split: of `arramon-server import-release`; every second episode in playing order is learned from, the second,
            fourth and so on, and the others are left to test on.
        init: weights to begin with; empty for the shipped ones.
        passes: number of epochs.
        batch: number of texts in a batch.
        learning_rate: the highest.
        seed: of new texts and the order of all.
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


RECIPES = {"reader": ReaderRecipe(), "reader_tuning": TuningRecipe()}


def smoke(recipe: ReaderRecipe | TuningRecipe) -> ReaderRecipe | TuningRecipe:
    """Return a recipe for smoke tests, which takes seconds and learns next to nothing."""
    recipe = replace(recipe, passes=1)
    return replace(recipe, texts=60) if isinstance(recipe, ReaderRecipe) else recipe
