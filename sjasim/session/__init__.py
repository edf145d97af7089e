"""One session: the loop around a world, and the protocol of a world."""
