"""What trained agents share: visual encoders, tokenizers, models, training, and the agent that plays with weights."""
