"""Planning of instructions: from the ground truth and what the camera sees along it to the meaning to be expressed."""
