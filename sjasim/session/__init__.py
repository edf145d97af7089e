"""One session: the loop that connects a world, the server and a method, and the protocol of a world."""
