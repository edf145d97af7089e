"""Tables of figures on a terminal."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from rich.console import Console
from rich.markup import escape
from rich.table import Table


def print_table(
    columns: Sequence[str], rows: Iterable[Sequence[str]], *, title: str = "", left: Sequence[int] = (0,)
) -> None:
    """Print a table on stdout.

    Args:
        columns: their names.
        rows: the cells of each row, as text.
        title: stands above the table.
        left: indices of the columns that are aligned to the left; the others are aligned to the right.
    """
    # Brackets are units here, such as [s], not rich's markup: so everything is escaped.
    table = Table(title=escape(title) or None)
    for index, name in enumerate(columns):
        table.add_column(escape(name), justify="left" if index in left else "right")
    for row in rows:
        table.add_row(*(escape(cell) for cell in row))
    Console().print(table)
