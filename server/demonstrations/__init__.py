"""Demonstrations: ground truth and recorded runs, rendered again, in the formats that training code reads."""
