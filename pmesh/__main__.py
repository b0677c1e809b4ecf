"""``python -m pmesh``: the pmesh command."""

from pmesh.cli import main

main()
