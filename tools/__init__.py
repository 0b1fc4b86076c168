"""What people run: the command line, reports, printable parts, simulation."""
