"""Small pure functions on arrays that the back ends share."""
