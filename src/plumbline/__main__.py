"""`python -m plumbline`: the command line, where the script `plumbline` is not on the path."""

from plumbline.harness.cli.main import main

main()
