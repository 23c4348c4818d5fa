"""Variants of a split's texts in the forms that people type: terse, with typing errors, romanised, mixed."""
