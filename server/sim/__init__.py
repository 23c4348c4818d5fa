"""The simulator: geometry, object catalogue, city, room, rules, collisions, cameras. No gRPC, no storage."""
