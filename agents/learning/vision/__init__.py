"""Visual encoders: `encoder.py` is their interface; every other module is the encoder of that name."""
