"""Visual encoders behind one interface: `encoder.py` is the interface, each other module an encoder by its own name."""
