"""Keeping BLAS to the thread that calls it."""

import threading
from functools import cache
from typing import Any, final

__all__ = ["single_threaded_blas"]


@final
class _SingleThreadedBLAS:
    """A context in which BLAS uses the calling thread alone; several threads may be in it at once.

    The dense blocks of a factor are small, threads that wait for their share of one burn time, and
    two factors keep two processors busy as it is. The limit is one of the whole process: the first
    thread to enter sets it, the last to leave lifts it.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._inside = 0
        self._limit: Any = None

    def __enter__(self) -> None:
        with self._lock:
            if self._inside == 0:
                self._limit = _pools().limit(limits=1, user_api="blas")
            self._inside += 1

    def __exit__(self, *_: object) -> None:
        with self._lock:
            self._inside -= 1
            if self._inside == 0:
                self._lift()

    def _lift(self) -> None:
        """Restore what was; threadpoolctl would listen only to the thread that set the limit."""
        pools = _pools().lib_controllers
        if any(pool.user_api == "blas" and pool.get_num_threads() != 1 for pool in pools):
            return  # somebody else has the say, and did not let us
        for pool in pools:
            if hasattr(pool, "clear_controlling_thread"):
                pool.clear_controlling_thread(force=True)
        self._limit.restore_original_limits()
        for pool in pools:
            if hasattr(pool, "clear_controlling_thread"):
                pool.clear_controlling_thread(force=True)


single_threaded_blas = _SingleThreadedBLAS()


@cache
def _pools() -> Any:
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()
