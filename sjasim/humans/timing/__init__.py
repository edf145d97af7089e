"""Human timing models: the times at which dancers begin and end their moves.

To write people of your own, implement `human_timing.HumanTiming` and name the class with ``--humans module:Class``.
"""
