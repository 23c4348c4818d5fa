"""The visual encoder "eyes": a small convolutional network that says what is where in a frame of RGB and depth."""
