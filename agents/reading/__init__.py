"""Language understanding of trained agents: tokenizers, text encoders, and the learned reader (a semantic parser)."""
