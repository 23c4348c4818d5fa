"""The simulator: geometry, object catalogue, city, room, rules, collisions and cameras, without gRPC or storage."""
