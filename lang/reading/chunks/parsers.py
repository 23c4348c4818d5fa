"""Choice of the parser of a text's chunks, by the phase and by where the language puts its relations."""

from arramon_lang.reading.chunks.postpositions import PlacementParser, PostpositionRouteParser
from arramon_lang.reading.chunks.prepositions import PrepositionRouteParser
from arramon_lang.reading.chunks.rules import ChunkRules

ChunkParser = type[PrepositionRouteParser] | type[PostpositionRouteParser] | type[PlacementParser]


def parser_for(rules: ChunkRules, phase: str) -> ChunkParser | None:
    """Return the parser of a language's texts of a phase, "navigation" or "assembly".

    It is None for assembly texts with prepositions, which the patterns that are only read cover as well.
    """
    if phase == "navigation":
        return PrepositionRouteParser if rules.has_prepositions else PostpositionRouteParser
    return None if rules.has_prepositions else PlacementParser
