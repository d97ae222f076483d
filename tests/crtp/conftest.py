"""What tests of the folders below share with these."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parent))
