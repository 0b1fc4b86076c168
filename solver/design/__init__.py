"""Which samples to take next: what each would teach, before it is taken."""
