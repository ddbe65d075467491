"""A bar for those who ask for one."""

from __future__ import annotations

import sys
from typing import Any


class ProgressBar:
    """By tqdm where it is installed, else a line on standard error."""

    def __init__(self) -> None:
        self._bar: Any = None
        try:
            from tqdm.auto import tqdm  # type: ignore[import-untyped,unused-ignore]
        except ImportError:
            return
        self._bar = tqdm(total=1.0, bar_format="{percentage:3.0f} %|{bar}| {desc} [{elapsed}]")

    def show(self, now: Any) -> None:
        """Draws where a run stands; the fraction may fall where new work was found."""
        what = f"{now.stage or 'starting'}, {now.iteration} iterations"
        if self._bar is None:
            sys.stderr.write(f"\r{100 * now.fraction:3.0f} % {what:60}")
            sys.stderr.flush()
        else:
            self._bar.n = min(max(now.fraction, 0.0), 1.0)
            self._bar.set_description_str(what)

    def close(self) -> None:
        """Leaves the last state standing."""
        if self._bar is None:
            sys.stderr.write("\n")
        else:
            self._bar.close()
