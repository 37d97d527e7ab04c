"""``python -m hoist_demo`` is the console command ``balance-rope``."""

import sys

from hoist_demo.command_line.main import main

if __name__ == "__main__":
    sys.exit(main())
