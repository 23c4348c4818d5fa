"""Pretrained encoders of third parties, from an installed package or a local folder: frozen, and never shipped."""
