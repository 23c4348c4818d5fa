"""Rendering for people: a picture of the agent's view, the map and the instruction, and a window that shows it."""

import os

import gymnasium
import numpy as np
import numpy.typing as npt

from arramon_client.environments.backend import Player
from arramon_client.environments.spaces import Dict
from arramon_client.printable import many_lines
from arramon_client.world import PHASES

VIEW_SIZE = 336
"""Side length of the view and the map, in pixels."""

TEXT_HEIGHT, LETTER, MARGIN = 120, 15, 8
"""Height of the text area, font size and margin, in pixels."""

BACKGROUND, INK = (250, 250, 248), (20, 20, 20)

INDIC_FONTS = (
    "NotoSansDevanagari-Regular.ttf", "NotoSerifDevanagari-Regular.ttf", "Lohit-Devanagari.ttf", "Mangal.ttf",
    "Nirmala.ttf", "FreeSans.ttf",
)  # fmt: skip
"""Fonts for Devanagari, which Pillow's own font lacks; the first one that is installed is used."""


class Picture:
    """Renders pictures of one environment."""

    def draw(self, values: Dict, player: Player) -> npt.NDArray[np.uint8]:
        """Return the picture of an observation, (456, 672, 3) uint8.

        Raises:
            gymnasium.error.DependencyNotInstalled: if Pillow is not installed.
        """
        try:
            from PIL import Image, ImageDraw
        except ImportError as error:
            raise gymnasium.error.DependencyNotInstalled(
                "rendering needs Pillow: pip install 'arramon-client[environments]'"
            ) from error
        whole = Image.new("RGB", (2 * VIEW_SIZE, VIEW_SIZE + TEXT_HEIGHT), BACKGROUND)
        view = agent_view(values)
        if view is not None:
            whole.paste(Image.fromarray(view).resize((VIEW_SIZE, VIEW_SIZE), Image.Resampling.NEAREST), (0, 0))
        above = player.map(VIEW_SIZE)
        if above is not None:
            whole.paste(Image.fromarray(above), (VIEW_SIZE, 0))
        text = many_lines(str(values["instruction"]))
        title = f"episode {player.episode_id}, turn {values['turn']}, {PHASES[int(values['phase'])]}, "
        title += f"{int(values['steps_left'][0])} steps left"
        draw, font = ImageDraw.Draw(whole), _font(text)
        top = VIEW_SIZE + MARGIN
        for line in (title, *_lines(text, 2 * VIEW_SIZE - 2 * MARGIN, draw, font)):
            draw.text((MARGIN, top), line, fill=INK, font=_font(line))
            top += LETTER + 5
        return np.asarray(whole)


class Window:
    """A window that shows pictures.

    Args:
        title: title of the window.
        rate: maximum number of pictures per second.

    Raises:
        gymnasium.error.DependencyNotInstalled: if pygame is not installed.
    """

    def __init__(self, title: str, rate: int) -> None:
        os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")  # Otherwise pygame prints a greeting.
        try:
            import pygame
        except ImportError as error:
            raise gymnasium.error.DependencyNotInstalled(
                "render_mode='human' needs pygame: pip install 'arramon-client[environments]'"
            ) from error
        self._pygame, self._rate = pygame, rate
        pygame.display.init()
        self._screen = pygame.display.set_mode((2 * VIEW_SIZE, VIEW_SIZE + TEXT_HEIGHT))
        pygame.display.set_caption(title)
        self._clock = pygame.time.Clock()

    def show(self, picture: npt.NDArray[np.uint8]) -> None:
        """Show a picture, (height, width, 3) uint8, and wait until the next one is due."""
        surface = self._pygame.surfarray.make_surface(picture.swapaxes(0, 1))
        self._screen.blit(surface, (0, 0))
        self._pygame.event.pump()
        self._pygame.display.flip()
        self._clock.tick(self._rate)

    def close(self) -> None:
        """Close the window."""
        self._pygame.display.quit()


def agent_view(values: Dict) -> npt.NDArray[np.uint8] | None:
    """Return the agent's view, (height, width, 3) uint8: RGB, else depth in grey; None without both sensors."""
    if "rgb" in values:
        rgb: npt.NDArray[np.uint8] = values["rgb"]
        return rgb
    if "depth" in values:
        grey = (255.0 / (1.0 + values["depth"] / 4.0)).astype(np.uint8)
        return np.repeat(grey[..., None], 3, axis=2)
    return None


def _font(text: str):  # type: ignore[no-untyped-def]  # Pillow's own union of fonts
    from PIL import ImageFont

    if not all(ord(character) < 256 for character in text):
        for name in INDIC_FONTS:
            try:
                return ImageFont.truetype(name, LETTER)
            except OSError:  # not installed
                continue
    return ImageFont.load_default(LETTER)


def _lines(text: str, width: int, draw, font) -> list[str]:  # type: ignore[no-untyped-def]
    lines: list[str] = []
    for word in text.split():
        longer = f"{lines[-1]} {word}" if lines else word
        if lines and draw.textlength(longer, font=font) <= width:
            lines[-1] = longer
        else:
            lines.append(word)
    return lines
