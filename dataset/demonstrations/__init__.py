"""Export of demonstrations: ground truth and recorded runs, rendered again, in formats for training code."""
