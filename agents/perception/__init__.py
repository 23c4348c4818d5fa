"""What agents perceive in a frame: visual encoders (`encoder.py` is their interface), and obstacles and landmarks."""
