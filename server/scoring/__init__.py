"""From a recorded trajectory to scores: pure functions that know nothing of the simulator, gRPC or storage."""
