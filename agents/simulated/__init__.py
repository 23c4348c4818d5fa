"""Training data from the simulator: labelled frames, and walks without images. Agents never import this at play."""
