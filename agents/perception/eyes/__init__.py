"""The visual encoder "eyes": small convolutional networks that recognise things in frames of RGB and depth."""
