"""Networks that others have trained, taken from an installed package or a local folder: frozen, and never shipped."""
