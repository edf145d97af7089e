"""Events from recorded joints of real or simulated sensors."""
