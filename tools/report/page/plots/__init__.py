"""The plots of the pages, as SVG, and the views in space that the page's script draws."""
