"""A shape to look at and click, as a page that a server on this computer gives to the browser.

The state of the page is in `session`, without a browser; `server` is the only module that imports
viser, and `controls` joins the two.
"""
