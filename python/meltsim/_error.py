# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations


class Error(RuntimeError):
    """What the library refuses or cannot do. The text names the field, its value and the fix; the World is unchanged.

    ``code`` is one of invalid_argument, version_mismatch, no_device, out_of_memory, capacity, step_too_large, halted,
    corrupt_data, interrupted, internal.
    """

    code: str

    def __init__(self, message: str, code: str = "internal") -> None:
        super().__init__(message)
        self.code = code

    def __reduce__(self) -> tuple[type[Error], tuple[str, str]]:
        return type(self), (str(self), self.code)
