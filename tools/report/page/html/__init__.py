"""What every page is made of: elements, tables, numbers, the style sheet and the scripts."""
