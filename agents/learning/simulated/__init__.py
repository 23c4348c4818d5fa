"""Free labels of the simulator, for training alone: no agent imports this at play."""
