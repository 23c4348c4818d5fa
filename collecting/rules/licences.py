"""Addresses of licences' texts."""

import re

_CREATIVE_COMMONS = re.compile(r"CC-(BY(?:-NC)?(?:-SA|-ND)?)-(\d\.\d)")


def licence_address(licence: str, language: str) -> str:
    """Return the address of a licence's summary, which links to its full text; "" if it is not known.

    Args:
        licence: SPDX identifier of the licence; the Creative Commons ones are known.
        language: code of the summary's language.
    """
    if licence == "CC0-1.0":
        return f"https://creativecommons.org/publicdomain/zero/1.0/deed.{language}"
    found = _CREATIVE_COMMONS.fullmatch(licence)
    return f"https://creativecommons.org/licenses/{found[1].lower()}/{found[2]}/deed.{language}" if found else ""
