"""Export of demonstrations: ground truth and recorded runs, re-rendered in formats for training code."""
