"""Parquet columns in the layout of the library `datasets`: images as PNG, arrays of numbers, and plain values."""

import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import datasets
import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.parquet as pq
from PIL import Image

from arramon_dataset.demonstrations.description import UNITS, shape_of
from arramon_dataset.demonstrations.rendering import RenderedDemonstration

COMPRESSION = "zstd"

PNG_LEVEL = 1
"""zlib level: higher levels take twice the time to save a tenth of the size."""


class TableFile:
    """A Parquet file that is written in batches of rows.

    Args:
        path: of the file.
        features: of the library `datasets`, by column.
    """

    def __init__(self, path: Path, features: "datasets.Features") -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        self._schema = _storage_schema(features)
        self._writer = pq.ParquetWriter(path, self._schema, compression=COMPRESSION)

    def write(self, columns: Mapping[str, Any]) -> None:
        """Append rows, given by column as pyarrow arrays or lists of values."""
        arrays = [_typed(columns[field.name], field.type) for field in self._schema]
        self._writer.write_table(pa.Table.from_arrays(arrays, schema=self._schema))

    def close(self) -> None:
        """Complete the file."""
        self._writer.close()


def feature_of(sensor: str, size: int) -> Any:
    """Return the feature of a sensor's column."""
    dtype, shape = UNITS[sensor][0], shape_of(sensor, size)
    if sensor == "rgb":
        return datasets.Image()
    if len(shape) == 1:
        return datasets.Sequence(datasets.Value(dtype), length=shape[0])
    return datasets.Array2D(shape=shape, dtype=dtype)


def sensor_column(rendered: RenderedDemonstration, sensor: str) -> pa.Array:
    """Return a sensor's values before each action as a lossless column."""
    values = [getattr(each, sensor) for each in rendered.action_observations]
    if sensor == "rgb":
        return png_column(values)
    if sensor == "pose":
        flat = pa.array(np.asarray(values, np.float64).reshape(-1))
        return pa.FixedSizeListArray.from_arrays(flat, 3)
    return grid_column(np.stack(values))


def png_column(frames: Sequence[npt.NDArray[np.uint8]]) -> pa.Array:
    """Return a column of images, (size, size, 3) uint8 each."""
    encoded = []
    for frame in frames:
        file = io.BytesIO()
        Image.fromarray(frame).save(file, format="PNG", compress_level=PNG_LEVEL)
        encoded.append(file.getvalue())
    paths = pa.nulls(len(encoded), pa.string())
    return pa.StructArray.from_arrays([pa.array(encoded, pa.binary()), paths], names=["bytes", "path"])


def grid_column(grids: npt.NDArray[Any]) -> pa.Array:
    """Return a column of lists of lists from an array of (rows, height, width)."""
    rows, height, width = grids.shape
    lines = pa.ListArray.from_arrays(
        np.arange(0, rows * height + 1, dtype=np.int32) * width, pa.array(grids.reshape(-1))
    )
    return pa.ListArray.from_arrays(np.arange(rows + 1, dtype=np.int32) * height, lines)


def _storage_schema(features: "datasets.Features") -> pa.Schema:
    """Return the schema of a file: plain lists for arrays, which every Parquet reader supports, and the features."""
    schema = features.arrow_schema
    plain = [
        pa.field(each.name, each.type.storage_type if isinstance(each.type, pa.ExtensionType) else each.type)
        for each in schema
    ]
    return pa.schema(plain, schema.metadata)


def _typed(values: Any, type_: pa.DataType) -> pa.Array:
    return values.cast(type_) if isinstance(values, pa.Array) else pa.array(values, type_)
