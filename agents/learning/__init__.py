"""Shared parts of trained agents: the agent that plays by weights, models, tokenizers, visual encoders, training."""
