"""`python -m fikm_drake.cli`."""

import sys

from fikm_drake.cli import main

sys.exit(main())
