"""The world: geometry, catalogue of objects, city, room, rules, physics, cameras. Knows nothing of gRPC or storage."""
