"""Text input of trained agents: tokenizers, and text encoders (readers) that give one vector for each token."""
