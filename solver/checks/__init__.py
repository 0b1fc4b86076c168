"""A look at recordings before they are fitted: what a person would want to know at once."""
