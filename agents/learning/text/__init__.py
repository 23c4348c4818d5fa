"""Text for trained agents: tokenizers, and readers that turn tokens into one vector."""
