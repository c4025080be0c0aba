# SPDX-License-Identifier: Apache-2.0
"""run.py FOLDER: its tests, or exit code 77 (SKIPPED) where pytest or NumPy is missing."""
import sys

try:
    import numpy  # noqa: F401
    import pytest
except ImportError as missing:
    print(f"SKIPPED: {missing}")
    sys.exit(77)
sys.exit(pytest.main(["-q", "-p", "no:cacheprovider", sys.argv[1]]))
