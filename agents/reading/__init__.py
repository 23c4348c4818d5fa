"""How trained agents read: tokenizers, text encoders, and the learned reader, which parses texts into steps."""
