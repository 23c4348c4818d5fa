"""Splits of the same episodes with their texts in another form."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from arramon_dataset.forms.forms import FORMS, check_form, episode_in_form
from arramon_server.episodes.demands import write_demands
from arramon_server.episodes.episode import Episode
from arramon_server.episodes.splits import Split, read_split, split_folder, write_split
from arramon_server.errors import BadInput, StorageError, quoted

PREFIX = "texts in the form "
"""Beginning of the `source` of splits with texts in a form."""


def form_split_name(split: str, form: str) -> str:
    """Return the name of the split with a split's texts in a form, such as "val_unseen_romanised"."""
    return f"{split}_{form}"


def write_form(data: Path, split: Split, form: str, languages: Sequence[str] = (), *, seed: int = 1) -> Split:
    """Write a split with the same episodes as another, their texts in a form, and return it.

    Args:
        data: the data folder.
        split: an open split with generated texts.
        form: one of `FORMS`.
        languages: codes; empty for all that the form and the split have.
        seed: the same seed gives the same texts.

    Raises:
        BadInput: if the split is hidden or has such texts already, does not have a language, or a text cannot be read;
            if the form is unknown, or a language does not have it.
        StorageError: if the folder cannot be written.
    """
    codes = _languages(split, form, languages)
    written: dict[str, Episode] = {}
    for code in codes:
        for name, episode in split.episodes.items():
            in_form = episode_in_form(episode, form, code, seed)
            if in_form is not None:
                texts = {**written[name].instructions, **in_form.instructions} if name in written else None
                written[name] = in_form if texts is None else replace(in_form, instructions=texts)
    made = write_split(
        data,
        form_split_name(split.name, form),
        hidden=False,
        source=f"{PREFIX}{form} ({', '.join(codes)}), seed {seed}, of {split.name} {split.data_hash[:12]}: "
        f"{split.source}",
        episodes=[written[name] for name in split.episodes if name in written],
        sections=split.sections.values(),
        training=split.training,
        provenance=split.provenance.values(),
    )
    if not split.demands:
        return made
    folder = split_folder(data, made.name)
    try:
        write_demands(folder, made.data_hash, {name: split.demands[name] for name in made.episodes})
    except OSError as error:
        raise StorageError(f"cannot write to {folder}: {error.strerror}") from error
    return read_split(folder)


def _languages(split: Split, form: str, languages: Sequence[str]) -> tuple[str, ...]:
    """Return the languages to write, after checking the arguments of `write_form`."""
    if form not in FORMS:
        check_form(form, "")
    if split.hidden:
        raise BadInput(f"split {quoted(split.name)} is hidden; texts in other forms can be written of open splits only")
    if split.source.startswith(PREFIX):
        raise BadInput(f"split {quoted(split.name)} has {split.source}; expected a split with its first texts")
    for code in languages:
        check_form(form, code)
        if code not in split.languages:
            listed = ", ".join(split.languages)
            raise BadInput(f"split {quoted(split.name)} has no texts in {quoted(code)}; it has {listed}")
    codes = tuple(languages) or tuple(code for code in FORMS[form] if code in split.languages)
    if not codes:
        listed = ", ".join(split.languages)
        raise BadInput(
            f"split {quoted(split.name)} has texts in {listed}; the form {form} exists in {', '.join(FORMS[form])}"
        )
    return codes
