"""Run a command, and write the peak of its memory in MB: python measured.py FILE COMMAND…"""

import os
import sys
from pathlib import Path

child = os.spawnvp(os.P_NOWAIT, sys.argv[2], sys.argv[2:])
_, status, usage = os.wait4(child, 0)
Path(sys.argv[1]).write_text(f"{usage.ru_maxrss / 1024:.1f}\n")
sys.exit(os.waitstatus_to_exitcode(status))
