"""Where results live: a local folder, or one at any URL that fsspec knows, such as `s3://bucket/study`."""

import os
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import fsspec
from fsspec.utils import get_protocol

from aeb_sumo.errors import InputError

__all__ = ["SUFFIX", "Place", "one_line"]

SUFFIX = ".parquet"
_LOCAL = ("file", "local")


@dataclass(frozen=True)
class Place:
    """A folder of results, `<table>/<run_id>.parquet` in it.

    A file system is not opened before it is needed: that of a URL may start a thread, and a world with threads cannot
    be forked.

    Attributes:
        name: as it was given.
    """

    name: str

    @classmethod
    def of(cls, out: "str | os.PathLike[str]") -> "Place":
        """A local path or a URL.

        Raises:
            InputError: it is empty, or fsspec does not know what is before its `://`, or lacks a package for it.
        """
        name = os.fspath(out)
        if not name.strip():
            raise InputError("the folder of results is empty; name a folder or a URL such as s3://bucket/folder")
        protocol = get_protocol(name)
        try:
            fsspec.get_filesystem_class(protocol)
        except (ValueError, ImportError) as error:
            raise InputError(f"cannot use {name}: {error}; name a local folder or a URL that fsspec knows") from None
        return cls(name)

    @cached_property
    def local(self) -> Path | None:
        """The path, if it is local."""
        if get_protocol(self.name) not in _LOCAL:
            return None
        return Path(self.name.removeprefix("file://").removeprefix("local://"))

    @cached_property
    def _opened(self) -> tuple[Any, str]:
        try:
            fs, root = fsspec.core.url_to_fs(self.name if self.local is None else str(self.local.absolute()))
        except Exception as error:  # whatever its package raises
            raise InputError(f"cannot open {self.name}: {one_line(error)}") from None
        return fs, str(root).rstrip("/")

    @property
    def fs(self) -> Any:
        """File system, as fsspec has it."""
        return self._opened[0]

    def path(self, table: str, run_id: str = "") -> str:
        """A table's folder, or the file of a run in it, as the file system names it."""
        folder = f"{self._opened[1]}/{table}"
        return f"{folder}/{run_id}{SUFFIX}" if run_id else folder

    def runs_of(self, table: str) -> set[str]:
        """Ids of all runs that have a file in a table, those that were not committed among them.

        Raises:
            InputError: the place cannot be listed.
        """
        try:
            # Nothing remembered: others write here, too.
            self.fs.invalidate_cache(self.path(table))
            names = [str(path).rpartition("/")[2] for path in self.fs.ls(self.path(table), detail=False)]
        except (FileNotFoundError, NotADirectoryError):
            return set()
        except Exception as error:
            raise InputError(f"cannot list {self.name}: {one_line(error)}") from None
        return {name.removesuffix(SUFFIX) for name in names if name.endswith(SUFFIX) and not name.startswith(".")}

    def remove(self, table: str, run_id: str) -> None:
        """Remove the file of a run, if it is there.

        Raises:
            InputError: it cannot be removed.
        """
        try:
            self.fs.rm_file(self.path(table, run_id))
        except FileNotFoundError:
            return
        except Exception as error:
            raise InputError(f"cannot write results into {self.name}: {one_line(error)}") from None

    def upload(self, file: Path, table: str, run_id: str) -> None:
        """Put a local file there. What decides whether a run exists comes under another name first, then its own.

        Raises:
            InputError: it cannot be put there.
        """
        target = self.path(table, run_id)
        partial = f"{self.path(table)}/.{run_id}{SUFFIX}.partial"
        try:
            self.fs.makedirs(self.path(table), exist_ok=True)
            self.fs.put_file(str(file), partial if table == "runs" else target)
            if table == "runs":
                self.fs.mv(partial, target)
        except Exception as error:  # whatever its package raises
            raise InputError(f"cannot write results into {self.name}: {one_line(error)}") from None


def one_line(error: BaseException) -> str:
    """What an exception says, in one line."""
    return " ".join(str(getattr(error, "strerror", None) or error).split()) or type(error).__name__
