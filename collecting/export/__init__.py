"""Export of a collection as a split, with the provenance of its texts."""
