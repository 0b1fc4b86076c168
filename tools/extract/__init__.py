"""From logs of joint states, such as bags, to recordings: one module a kind of log."""
