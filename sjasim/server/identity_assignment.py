"""Who is who: identities that are local to a sensor -> names of the cast."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from scipy.optimize import linear_sum_assignment

from ..core import Array, PersonStatus

NEAR_M = 0.25
"""A person this close to where their name was last seen is still the same; below half the least distance of two
slots (.6 m)."""

REACH_M = 0.5
REACH_M_S = 1.0
"""How far from where it was last seen a name is looked for: a reach that grows with the time since (assumed: nobody
in this dance walks faster)."""

_FAR = 1e6


class IdentityAssigner:
    """Names for the persons that sensors report, by their place on the floor.

    At the start everyone stands on their slot; from then on a name goes to whoever continues its path, in whichever
    sensor, whatever local identity that sensor gives them. A person nobody's path leads to stays nameless.

    Args:
        names: the cast.
        slots_m: (D, 2) where each of them stands at the start [m].
    """

    def __init__(self, names: Sequence[str], slots_m: Array) -> None:
        self._names = tuple(names)
        self._places = [(float(x), float(y)) for x, y in slots_m]
        self._seen_s = [0.0] * len(self._names)
        self._index: dict[str, dict[int, int]] = {}

    def known(self, sensor: str) -> Mapping[int, int]:
        """A sensor's persons by their places in the cast; once somebody is another one, in another mapping."""
        return self._index.get(sensor, {})

    def name(self, sensor: str, person: int) -> str | None:
        """Cast name of a sensor's person, by its last report; None for somebody unknown."""
        index = self._index.get(sensor, {}).get(person)
        return None if index is None else self._names[index]

    def local(self, sensor: str, name: str) -> int | None:
        """A sensor's own identity for a member of the cast; None where it does not see them."""
        index = self._names.index(name)
        return next((person for person, known in self._index.get(sensor, {}).items() if known == index), None)

    def update(self, sensor: str, t_s: float, persons: Sequence[PersonStatus]) -> None:
        """Take in where a sensor sees whom.

        Args:
            sensor: whose report.
            t_s: session time of the report.
            persons: everyone it sees; somebody it has lost is simply not there, and a place that is not finite
                counts as lost.
        """
        known = self._index.get(sensor, {})
        if not self._go_on(known, persons):
            persons = [person for person in persons if math.isfinite(person.x_m) and math.isfinite(person.y_m)]
            known = self._index[sensor] = self._renamed(known, t_s, persons)
        for person in persons:
            index = known.get(person.person)
            if index is not None:
                self._places[index] = (person.x_m, person.y_m)
                self._seen_s[index] = t_s

    def _go_on(self, known: Mapping[int, int], persons: Sequence[PersonStatus]) -> bool:
        """Whether everybody is known and still where their name was."""
        for person in persons:
            index = known.get(person.person)
            if index is None or not self._distance(index, person) <= NEAR_M:
                return False
        return True

    def _renamed(self, known: Mapping[int, int], t_s: float, persons: Sequence[PersonStatus]) -> dict[int, int]:
        """Who is who, of those a sensor sees and those it has just lost."""
        kept = [known.get(person.person) for person in persons]
        if any(index is None or self._distance(index, person) > NEAR_M
               for index, person in zip(kept, persons, strict=True)):  # fmt: skip
            kept = self._assigned(t_s, persons)
        present = {person.person: index for index, person in zip(kept, persons, strict=True) if index is not None}
        for person_id, index in known.items():
            if person_id not in present and index not in present.values():
                present[person_id] = index  # an event of somebody just lost may still be under way
        return present

    def _distance(self, index: int, person: PersonStatus) -> float:
        x, y = self._places[index]
        return math.hypot(person.x_m - x, person.y_m - y)

    def _assigned(self, t_s: float, persons: Sequence[PersonStatus]) -> list[int | None]:
        """The names that fit best together; None for a person whom no name can have reached."""
        cost = np.full((len(persons), len(self._names)), _FAR)
        for row, person in enumerate(persons):
            for index in range(len(self._names)):
                reach = REACH_M + REACH_M_S * max(t_s - self._seen_s[index], 0.0)
                distance = self._distance(index, person)
                if distance <= reach:
                    cost[row, index] = distance
        found: list[int | None] = [None] * len(persons)
        for row, index in zip(*linear_sum_assignment(cost), strict=True):
            if cost[row, index] < _FAR:
                found[int(row)] = int(index)
        return found
