"""Compiled loops over pixels: network inputs, walls, solid pixels, and measures and crops of things on the ground."""

import numpy as np
import numpy.typing as npt

from arramon_agents.compilation import compiled

Floats = npt.NDArray[np.float32]


@compiled
def fill_input(
    rgb: npt.NDArray[np.uint8],
    depth: Floats,
    down: Floats,
    eye: float,
    low: float,
    high: float,
    patch: int,
    out: Floats,
) -> None:
    """Compute the network's input of a frame: colours, nearness, and height above the ground on two scales.

    Args:
        rgb: (size, size, 3).
        depth: (size, size) units, 0 where there is nothing.
        down: (size,) how far the rays of each row go down, per unit ahead.
        eye: height of the camera, in units.
        low, high: heights at which the scales end, in units.
        patch: side length of a patch, in pixels.
        out: (size / patch, size / patch, 6 * patch * patch), written: the pixels of a patch, channel by channel.
    """
    area = patch * patch
    scale, middle = np.float32(1.0 / 255.0), np.float32(0.5)
    for i in range(patch * out.shape[0]):
        row, first = i // patch, i % patch * patch
        for column in range(out.shape[1]):
            values = out[row, column]
            for step in range(patch):
                place, j = first + step, column * patch + step
                for k in range(3):
                    values[k * area + place] = rgb[i, j, k] * scale - middle
                z = depth[i, j]
                height, nearness = high, 0.0
                if z > 0.0:
                    height = max(eye - down[i] * z, 0.0)
                    nearness = 2.0 / (1.0 + z)
                values[3 * area + place] = nearness
                values[4 * area + place] = min(height, low) / low
                values[5 * area + place] = min(height, high) / high


@compiled
def _continue_walls(walls: Floats) -> None:
    """Interpolate and extrapolate the depth of walls from columns where it is known: its inverse is linear."""
    size = len(walls)
    last = -1
    for j in range(size):
        if walls[j] > 0.0:
            if last >= 0 and j - last > 1:
                for k in range(last + 1, j):
                    share = np.float32(k - last) / np.float32(j - last)
                    walls[k] = 1.0 / ((1.0 - share) / walls[last] + share / walls[j])
            last = j
    if last < 0:
        return
    first = 0
    while walls[first] == 0.0:
        first += 1
    reach = min(16, last - first)
    if reach < 8:
        return
    slope = (1.0 / walls[first] - 1.0 / walls[first + reach]) / reach
    for k in range(first):
        inverse = 1.0 / walls[first] + slope * (first - k)
        walls[k] = 1.0 / inverse if inverse > 0.0 else 0.0
    slope = (1.0 / walls[last] - 1.0 / walls[last - reach]) / reach
    for k in range(last + 1, size):
        inverse = 1.0 / walls[last] + slope * (k - last)
        walls[k] = 1.0 / inverse if inverse > 0.0 else 0.0


@compiled
def find_walls(depth: Floats, down: Floats, eye: float, tall: float, foot: float, wide: float, out: Floats) -> None:
    """Compute the depth of the nearest wall in each column, 0 for none.

    In a column, an upright wall has a single depth, is visible both high and low, and continues in neighbouring columns
    (a post does not). Where it is hidden, its depth is extrapolated from the neighbouring columns.

    Args:
        depth: (size, size) units, 0 where there is nothing.
        down: (size,) how far the rays of each row go down, per unit ahead.
        eye: height of the camera, in units.
        tall, foot: heights above and below which a part of the wall must be visible, in units.
        wide: minimum width of a wall, in units.
        out: (size,), written.
    """
    size = depth.shape[0]
    runs = np.zeros((size, 3), np.float32)  # Depth, upper and lower end of pixels of one depth.
    for j in range(size):
        out[j] = 0.0
        count = 0
        i = 0
        while i < size:
            z = depth[i, j]
            rows = 1
            while i + rows < size and abs(depth[i + rows, j] - z) < np.float32(0.002):
                rows += 1
            if z > 0.0 and rows >= 3:
                runs[count, 0] = z
                runs[count, 1] = eye - down[i] * z
                runs[count, 2] = eye - down[i + rows - 1] * z
                count += 1
            i += rows
        for k in range(count):
            z = runs[k, 0]
            if runs[k, 1] > tall and (out[j] == 0.0 or z < out[j]):
                for m in range(k, count):
                    if abs(runs[m, 0] - z) < np.float32(0.003) and runs[m, 2] < foot:
                        out[j] = z
                        break
    pixel = down[1] - down[0]
    j = 0
    while j < size:
        end = j + 1
        while end < size and out[j] > 0.0 and abs(out[end] - out[end - 1]) < np.float32(0.08) * out[end - 1]:
            end += 1
        if (end - j) * pixel * out[j] + abs(out[end - 1] - out[j]) < wide:
            out[j:end] = 0.0
        j = end
    _continue_walls(out)


@compiled
def mark_solid(
    depth: Floats,
    walls: Floats,
    down: Floats,
    eye: float,
    lowest: float,
    highest: float,
    farthest: float,
    jump: float,
    relative: float,
    out: npt.NDArray[np.bool_],
) -> None:
    """Mark the pixels of things in front of walls, except those behind a jump in depth, which separate things.

    Args:
        depth: (size, size) units, 0 where there is nothing.
        walls: (size,) depth of the wall in each column, 0 without any.
        down: (size,) how far the rays of each row go down, per unit ahead.
        eye: height of the camera, in units.
        lowest, highest: range of heights above the ground, in units.
        farthest: maximum distance ahead, in units.
        jump, relative: minimum jump in depth: in units, plus a share of the smaller depth.
        out: (size, size), written.
    """
    size = depth.shape[0]
    for i in range(size):
        for j in range(size):
            z = depth[i, j]
            height = eye - down[i] * z
            solid = z > 0.0 and z < farthest and height > lowest and height < highest
            if solid and walls[j] > 0.0 and abs(z - walls[j]) < np.float32(0.005) + np.float32(0.002) * z:
                solid = False
            if solid:
                for di, dj in ((-1, 0), (1, 0), (0, -1), (0, 1)):
                    y, x = i + di, j + dj
                    if y >= 0 and y < size and x >= 0 and x < size:
                        near = depth[y, x]
                        if near > 0.0 and z - near > jump + relative * near:
                            solid = False
            out[i, j] = solid


@compiled
def _first_number(parents: npt.NDArray[np.int32], number: int) -> int:
    """Return the first provisional number of a part; arguments as in `number_parts`."""
    while parents[number] != number:
        number = parents[number]
    return number


@compiled
def _renumber(parents: npt.NDArray[np.int32], provisional: int) -> int:
    """Replace the parents by the final numbers of parts, and return how many there are; as in `number_parts`."""
    count = 0
    for number in range(1, provisional + 1):
        if parents[number] == number:
            count += 1
            parents[number] = count
        else:
            parents[number] = parents[parents[number]]
    return count


@compiled
def number_parts(marked: npt.NDArray[np.bool_], out: npt.NDArray[np.int32]) -> int:
    """Number the connected parts of marked pixels in the order of their first pixels, and return how many there are.

    Pixels are connected to those above, below, left and right of them.

    Args:
        marked: (rows, columns).
        out: (rows, columns) written: number of the part that each pixel belongs to, from 1; 0 for none.
    """
    rows, columns = marked.shape
    parents = np.zeros(rows * columns // 2 + 2, np.int32)  # Provisional numbers, each with an earlier one of its part.
    provisional = 0
    for i in range(rows):
        for j in range(columns):
            if not marked[i, j]:
                out[i, j] = 0
                continue
            above, left = 0, 0
            if i > 0:
                above = out[i - 1, j]
            if j > 0:
                left = out[i, j - 1]
            if above == 0 and left == 0:
                provisional += 1
                parents[provisional] = provisional
                out[i, j] = provisional
            elif above == 0 or left == 0 or above == left:
                out[i, j] = max(above, left)
            else:
                above, left = _first_number(parents, above), _first_number(parents, left)
                first = min(above, left)
                parents[above] = parents[left] = first
                out[i, j] = first
    count = _renumber(parents, provisional)
    for i in range(rows):
        for j in range(columns):
            out[i, j] = parents[out[i, j]]
    return count


@compiled
def number_rims(
    depth: Floats, walls: Floats, numbers: npt.NDArray[np.int32], before: float, out: npt.NDArray[np.int32]
) -> None:
    """Number the pixels before the walls that are of no part, but beside one: by the neighbour of the nearest depth.

    They are rims behind a jump in depth, such as the far rim of a bucket.

    Args:
        depth: (size, size) units, 0 where there is nothing.
        walls: (size,) depth of the wall in each column, 0 without any.
        numbers: (size, size) number of the part that each pixel belongs to, from 1; 0 for none.
        before: distance before the wall of its column, in units, from which a pixel is not of the wall.
        out: (size, size), written: numbers of parts, 0 for pixels that are no rims.
    """
    size = depth.shape[0]
    for i in range(size):
        for j in range(size):
            out[i, j] = 0
            z = depth[i, j]
            if numbers[i, j] > 0 or z <= 0.0 or z >= walls[j] - before:
                continue
            nearest = np.float32(np.inf)
            for y in range(max(i - 1, 0), min(i + 2, size)):
                for x in range(max(j - 1, 0), min(j + 2, size)):
                    if numbers[y, x] > 0 and abs(depth[y, x] - z) < nearest:
                        nearest = abs(depth[y, x] - z)
                        out[i, j] = numbers[y, x]


@compiled
def label_surfaces(
    rgb: npt.NDArray[np.uint8],
    depth: Floats,
    upright: npt.NDArray[np.int64],
    flat: npt.NDArray[np.int64],
    down: Floats,
    eye: float,
    lowest: float,
    crossing: int,
    road: int,
    brightness: int,
    out: npt.NDArray[np.uint16],
) -> None:
    """Compute the label of each pixel from the labels of its block: one for upright surfaces, one for the ground.

    Args:
        rgb: (size, size, 3).
        depth: (size, size) units, 0 where there is nothing.
        upright, flat: (blocks, blocks) labels of upright surfaces, and of the ground and the sky.
        down: (size,) how far the rays of each row go down, per unit ahead.
        eye: height of the camera, in units.
        lowest: height above the ground above which a pixel is upright, in units.
        crossing, road: labels of zebra crossings and of roads.
        brightness: minimum of red, green and blue of a crossing's stripes; other pixels of a crossing are road.
        out: (size, size), written.
    """
    size = depth.shape[0]
    side = size // flat.shape[0]
    camera, threshold = np.float32(eye), np.float32(lowest)
    for i in range(size):
        for j in range(size):
            z = depth[i, j]
            label = flat[i // side, j // side]
            if z > 0.0 and camera - down[i] * z > threshold:
                label = upright[i // side, j // side]
            if label == crossing and min(rgb[i, j, 0], rgb[i, j, 1], rgb[i, j, 2]) < brightness:
                label = road
            out[i, j] = label


@compiled
def measure_parts(
    numbers: npt.NDArray[np.int32],
    depth: Floats,
    across: Floats,
    eye: float,
    boxes: npt.NDArray[np.int64],
    pixels: npt.NDArray[np.int64],
    spans: Floats,
) -> None:
    """Compute the bounding box, the number of pixels and the extent of each connected part of a frame.

    Args:
        numbers: (size, size) number of the part that each pixel belongs to, from 1; 0 for none.
        depth: (size, size) units.
        across: (size,) how far the rays of each column go right, and of each row down, per unit ahead.
        eye: height of the camera, in units.
        boxes: (parts, 4) written: first row and column, end row and column (exclusive).
        pixels: (parts,) zeros, written.
        spans: (parts, 4) written: left and right end, lower and upper end, in units; right and up are positive.
    """
    size = depth.shape[0]
    eye_height = np.float32(eye)
    for i in range(size):
        for j in range(size):
            part = numbers[i, j] - 1
            if part < 0:
                continue
            z = depth[i, j]
            right, height = across[j] * z, eye_height - across[i] * z
            if pixels[part] == 0:
                boxes[part, 0], boxes[part, 1], boxes[part, 2], boxes[part, 3] = i, j, i + 1, j + 1
                spans[part, 0], spans[part, 1], spans[part, 2], spans[part, 3] = right, right, height, height
            else:
                boxes[part, 1], boxes[part, 2] = min(boxes[part, 1], j), i + 1
                boxes[part, 3] = max(boxes[part, 3], j + 1)
                spans[part, 0], spans[part, 1] = min(spans[part, 0], right), max(spans[part, 1], right)
                spans[part, 2], spans[part, 3] = min(spans[part, 2], height), max(spans[part, 3], height)
            pixels[part] += 1


@compiled
def fill_crop(
    rgb: npt.NDArray[np.uint8],
    depth: Floats,
    rows: npt.NDArray[np.int64],
    columns: npt.NDArray[np.int64],
    mask: npt.NDArray[np.bool_],
    first: tuple[int, int],
    down: Floats,
    eye: float,
    ahead: float,
    out: Floats,
) -> None:
    """Compute the crop of a thing: colours, mask, height above the ground, and distance behind its centre.

    Args:
        rgb: (size, size, 3).
        depth: (size, size) units.
        rows, columns: (n,) row and column of the frame for each of the crop; pixels outside the frame stay 0.
        mask: which pixels of the thing's bounding box belong to it.
        first: first row and column of the box.
        down: (size,) how far the rays of each row go down, per unit ahead.
        eye: height of the camera, in units.
        ahead: distance of the thing's centre, in units.
        out: (n, n, 6), zeros.
    """
    size = depth.shape[0]
    for i in range(len(rows)):
        row = rows[i]
        if row < 0 or row >= size:
            continue
        for j in range(len(columns)):
            column = columns[j]
            if column < 0 or column >= size:
                continue
            for k in range(3):
                out[i, j, k] = rgb[row, column, k] * np.float32(1.0 / 255.0)
            y, x = row - first[0], column - first[1]
            if y >= 0 and y < mask.shape[0] and x >= 0 and x < mask.shape[1] and mask[y, x]:
                out[i, j, 3] = 1.0
            z = depth[row, column]
            out[i, j, 4] = min(max(eye - down[row] * z, 0.0), 1.0)
            out[i, j, 5] = min(max((z - ahead) * 2.0, -1.0), 1.0)
