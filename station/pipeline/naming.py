"""Names that tell files apart: as short as they can be, with folders only where needed."""

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from station.errors import InputUnusable


def distinct_names(paths: Sequence[Path]) -> list[str]:
    """Return for each path the shortest end of it that no other path has as its name.

    Raises
    ------
    InputUnusable
        If a file is given twice: its points would count double.

    Examples
    --------
    >>> distinct_names([Path("monday/1.png"), Path("tuesday/1.png"), Path("tuesday/2.png")])
    ['monday/1.png', 'tuesday/1.png', '2.png']
    """
    full = [path.absolute().parts for path in paths]
    (most, times), *_ = Counter(full).most_common(1) or [((), 0)]
    if times > 1:
        raise InputUnusable(f"{Path(*most)}: given {times} times; give each source once")
    lengths = [1] * len(full)
    while True:
        names = [parts[-length:] for parts, length in zip(full, lengths, strict=True)]
        taken = Counter(names)
        if max(taken.values(), default=1) == 1:
            return [Path(*name).as_posix() for name in names]
        lengths = [length + (taken[name] > 1) for name, length in zip(names, lengths, strict=True)]
