"""The command line: `station COMMAND`.

Exit 0 done; 1 the work was done and the answer is no; 2 unusable input, said in one line.
"""

from station.cli.main import main

__all__ = ["main"]
