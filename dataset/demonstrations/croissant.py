"""The Croissant file of an export: what its files and columns are, for catalogues and loaders of data sets."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from arramon_dataset.demonstrations.description import describe
from arramon_dataset.demonstrations.folder import ExportFolder, as_json
from arramon_dataset.demonstrations.request import Export

FILE = "croissant.json"

MIT = "https://opensource.org/license/mit"
"""Licence of generated data, as of the project. Texts of imported episodes have that of their authors."""

_NAMES = (
    "citeAs", "column", "equivalentProperty", "extract", "field", "fileProperty", "fileObject", "fileSet", "format",
    "includes", "isLiveDataset", "jsonPath", "key", "md5", "parentField", "path", "recordSet", "references", "regex",
    "repeated", "replace", "samplingRate", "separator", "source", "subField", "transform",
)  # fmt: skip

CONTEXT: dict[str, Any] = {
    "@language": "en",
    "@vocab": "https://schema.org/",
    "sc": "https://schema.org/",
    "cr": "http://mlcommons.org/croissant/",
    "rai": "http://mlcommons.org/croissant/RAI/",
    "dct": "http://purl.org/dc/terms/",
    **{name: f"cr:{name}" for name in _NAMES},
    "conformsTo": "dct:conformsTo",
    "data": {"@id": "cr:data", "@type": "@json"},
    "dataType": {"@id": "cr:dataType", "@type": "@vocab"},
    "examples": {"@id": "cr:examples", "@type": "@json"},
}
"""The context that Croissant 1.0 prescribes."""


@dataclass(frozen=True, slots=True)
class CroissantField:
    """A column of the files.

    Attributes:
        column: its name.
        type: such as "sc:Text".
        description: meaning, with unit.
        path: JSON path within the column's values; "" for the values themselves.
    """

    column: str
    type: str
    description: str
    path: str = ""


@dataclass(frozen=True, slots=True)
class CroissantFiles:
    """A set of files with equal columns.

    Attributes:
        name: of the set.
        files: pattern of their paths in the export's folder.
        encoding: MIME type.
        fields: columns that Croissant's types can express; none where loaders of Croissant do not read the files.
    """

    name: str
    files: str
    encoding: str
    fields: Sequence[CroissantField] = ()


def write_croissant(export: Export, folder: ExportFolder, sets: Sequence[CroissantFiles]) -> None:
    """Write the Croissant file of an export."""
    request = export.request
    document: dict[str, Any] = {
        "@context": CONTEXT,
        "@type": "sc:Dataset",
        "conformsTo": "http://mlcommons.org/croissant/1.0",
        "name": f"arramon-{request.split}-{request.format}",
        "description": describe(export),
        "url": "https://aclanthology.org/2020.findings-emnlp.348/",
        "citeAs": "Kim et al., ArraMon, Findings of EMNLP 2020",
        "version": "1.0.0",
        "inLanguage": list(request.languages),
        **({"license": MIT} if is_generated(export) else {}),
        "distribution": [
            {
                "@type": "cr:FileSet",
                "@id": f"{records.name}-files",
                "name": f"{records.name}-files",
                "encodingFormat": records.encoding,
                "includes": records.files,
            }
            for records in sets
        ],
        "recordSet": [_record_set(records) for records in sets if records.fields],
    }
    folder.write_text(FILE, as_json(document))


def is_generated(export: Export) -> bool:
    """Return whether the project itself made the episodes, not an import."""
    return export.source.startswith("generated")


def _record_set(records: CroissantFiles) -> dict[str, Any]:
    return {
        "@type": "cr:RecordSet",
        "@id": records.name,
        "name": records.name,
        "field": [
            {
                "@type": "cr:Field",
                "@id": f"{records.name}/{field.column}",
                "name": field.column,
                "description": field.description,
                "dataType": field.type,
                "source": {
                    "fileSet": {"@id": f"{records.name}-files"},
                    "extract": {"column": field.column},
                    **({"transform": {"jsonPath": field.path}} if field.path else {}),
                },
            }
            for field in records.fields
        ],
    }
