"""Training data from the simulator: labelled frames, simulated walks without images, texts. Not imported at play."""
